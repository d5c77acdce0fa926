#include "conformance/driver/evaluate.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "conformance/driver/plain_text.h"

namespace t4d::conformance {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kQuotedBytes = 300;
constexpr std::size_t kShownDifferences = 3;

/// The end of its standard error, where Python and others report what went wrong.
std::string lastWords(const Reply& reply, const std::string& path) {
  std::string text = reply.message;
  for (std::size_t at = 0; (at = text.find(path, at)) != std::string::npos; at += 4) {
    text.replace(at, path.size(), "FILE");
  }
  text.erase(text.find_last_not_of(" \n\r\t") + 1);
  constexpr int kLines = 3;
  std::size_t from = text.size();
  for (int line = 0; line < kLines && from != std::string::npos && from > 0; ++line) {
    from = text.rfind('\n', from - 1);
  }
  text.erase(0, from == std::string::npos ? 0 : from + 1);
  if (text.size() > kQuotedBytes) text = "..." + text.substr(text.size() - kQuotedBytes);
  return text.empty() ? "it said nothing" : "it said: " + plain(text);
}

std::string signalName(int number) {
  const char* name = sigabbrev_np(number);
  return name == nullptr ? "" : fmt::format(" (SIG{})", name);
}

TrialResult evaluateAnswer(const Trial& trial, const Reply& reply) {
  if (trial.answer.json.empty()) return {};
  std::vector<std::string> wrong;
  try {
    wrong = differences(trial.answer, reply.output);
  } catch (const ordered_json::parse_error& error) {
    if (reply.output.find_first_not_of(" \n\r\t") == std::string::npos) {
      return {Outcome::Failed, "accepted, but it printed nothing"};
    }
    constexpr std::size_t kShown = 80;
    const std::size_t at = error.byte > 0 ? error.byte - 1 : 0;
    return {Outcome::Failed,
            fmt::format("accepted, but what it printed is not one JSON object: wrong from byte {}, "
                        "\"{}\"",
                        at, plain(std::string_view(reply.output).substr(at), kShown))};
  } catch (const ordered_json::out_of_range& error) {
    return {Outcome::Failed, "accepted, but its JSON has a number beyond doubles: " +
                                 plain(error.what(), kQuotedBytes)};
  }
  if (wrong.empty()) return {};
  std::string message;
  for (std::size_t i = 0; i < std::min(wrong.size(), kShownDifferences); ++i) {
    message += (i == 0 ? "" : "; ") + plain(wrong[i], kQuotedBytes);
  }
  if (wrong.size() > kShownDifferences) {
    message += fmt::format("; and {} more", wrong.size() - kShownDifferences);
  }
  return {Outcome::Failed, message};
}

}  // namespace

const char* nameOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::Passed:
      return "passed";
    case Outcome::Skipped:
      return "skipped";
    case Outcome::Failed:
      return "failed";
    case Outcome::TimedOut:
      return "timed_out";
    case Outcome::Crashed:
      break;
  }
  return "crashed";
}

Reply replyOf(platform::ProgramRun run) {
  using End = platform::ProgramRun::End;
  Reply reply;
  switch (run.end) {
    case End::Exited:
      reply.kind = run.code == 0   ? Reply::Kind::Accepted
                   : run.code == 1 ? Reply::Kind::Refused
                                   : Reply::Kind::Exited;
      break;
    case End::Signalled:
      reply.kind = Reply::Kind::Signalled;
      break;
    case End::TimedOut:
      reply.kind = Reply::Kind::TimedOut;
      break;
    case End::Stopped:
      reply.kind = Reply::Kind::Stopped;
      break;
  }
  reply.code = run.code;
  reply.output = std::move(run.output);
  reply.message = std::move(run.message);
  reply.seconds = run.seconds;
  return reply;
}

TrialResult evaluate(const Trial& trial, const Reply& reply, const std::string& path,
                     double timeoutSeconds) {
  const auto result = [&](Outcome outcome, std::string message) {
    return TrialResult{outcome, std::move(message), reply.seconds};
  };
  switch (reply.kind) {
    case Reply::Kind::Stopped:
      return result(Outcome::Skipped, "stopped");
    case Reply::Kind::TimedOut: {
      const double byTheClock = platform::TimeLimit::ofProcessor(timeoutSeconds).seconds;
      const bool waited = reply.seconds >= byTheClock;
      return result(Outcome::TimedOut,
                    fmt::format("no answer within {} s{}; {}", waited ? byTheClock : timeoutSeconds,
                                waited ? ", most of which it waited" : " of processor time",
                                lastWords(reply, path)));
    }
    case Reply::Kind::Signalled:
      return result(Outcome::Crashed, fmt::format("ended by signal {}{}; {}", reply.code,
                                                  signalName(reply.code), lastWords(reply, path)));
    case Reply::Kind::Exited:
      return result(Outcome::Crashed,
                    fmt::format("ended with exit code {}{}; {}", reply.code,
                                reply.code == 0 || reply.code == 1
                                    ? " instead of answering"
                                    : ", which is neither 0 (accepted) nor 1 (refused)",
                                lastWords(reply, path)));
    case Reply::Kind::Malformed:
      return result(Outcome::Crashed, reply.message);
    case Reply::Kind::Accepted:
    case Reply::Kind::Refused:
      break;
  }
  const bool accepted = reply.kind == Reply::Kind::Accepted;
  const std::string& wrong = accepted ? trial.wrongToAccept : trial.wrongToRefuse;
  if (!wrong.empty()) {
    return result(Outcome::Failed,
                  accepted ? fmt::format("accepted, but {}", wrong)
                           : fmt::format("refused, but {}; {}", wrong, lastWords(reply, path)));
  }
  TrialResult answered = accepted ? evaluateAnswer(trial, reply) : TrialResult{};
  answered.seconds = reply.seconds;
  return answered;
}

}  // namespace t4d::conformance
