#include "t4d/conformance/driver/evaluate.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/conformance/driver/plain_text.h"

namespace t4d::conformance {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kQuotedBytes = 300;
constexpr std::size_t kShownDifferences = 3;

/// The end of what it wrote to standard error, where Python and others say what went wrong.
std::string lastWords(const system::ProgramRun& run, const std::string& path) {
  std::string text = run.message;
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

TrialResult evaluateAnswer(const Trial& trial, const system::ProgramRun& run) {
  if (trial.answer.json.empty()) return {};
  ordered_json actual;
  try {
    actual = ordered_json::parse(run.output);
  } catch (const ordered_json::parse_error& error) {
    if (run.output.find_first_not_of(" \n\r\t") == std::string::npos) {
      return {Outcome::Failed, "accepted, but it printed nothing"};
    }
    constexpr std::size_t kShown = 80;
    const std::size_t at = error.byte > 0 ? error.byte - 1 : 0;
    return {Outcome::Failed,
            fmt::format("accepted, but what it printed is not one JSON object: wrong from byte {}, "
                        "\"{}\"",
                        at, plain(std::string_view(run.output).substr(at), kShown))};
  }
  const std::vector<std::string> wrong = differences(
      ordered_json::parse(trial.answer.json), ordered_json::parse(trial.answer.within), actual);
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

TrialResult evaluate(const Trial& trial, const system::ProgramRun& run, const std::string& path,
                     double seconds) {
  switch (run.end) {
    case system::ProgramRun::End::Stopped:
      return {Outcome::Skipped, "stopped"};
    case system::ProgramRun::End::TimedOut:
      return {Outcome::TimedOut,
              fmt::format("did not end within {} s; {}", seconds, lastWords(run, path))};
    case system::ProgramRun::End::Signalled:
      return {Outcome::Crashed, fmt::format("ended by signal {}{}; {}", run.code,
                                            signalName(run.code), lastWords(run, path))};
    case system::ProgramRun::End::Exited:
      break;
  }
  if (run.code != 0 && run.code != 1) {
    return {
        Outcome::Crashed,
        fmt::format("ended with exit code {}, which is neither 0 (accepted) nor 1 (refused); {}",
                    run.code, lastWords(run, path))};
  }
  const bool accepted = run.code == 0;
  const std::string& wrong = accepted ? trial.wrongToAccept : trial.wrongToRefuse;
  if (!wrong.empty()) {
    return {Outcome::Failed, accepted
                                 ? fmt::format("accepted, but {}", wrong)
                                 : fmt::format("refused, but {}; {}", wrong, lastWords(run, path))};
  }
  return accepted ? evaluateAnswer(trial, run) : TrialResult{};
}

}  // namespace t4d::conformance
