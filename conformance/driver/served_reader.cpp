#include "conformance/driver/served_reader.h"

#include <fmt/format.h>

#include "conformance/driver/plain_text.h"
#include "platform/stopwatch.h"

namespace t4d::conformance {
namespace {

using platform::ChildProcess;
using platform::ProgramRun;

constexpr std::size_t kAnswerBytes = std::size_t{16} << 20;
constexpr std::size_t kQuotedLineBytes = 80;

/// Parses a reply line: the first word is the verdict, the rest the answer or message.
Reply parsed(const std::string& line) {
  Reply reply;
  const std::size_t space = line.find(' ');
  const std::string word = line.substr(0, space);
  std::string rest = space == std::string::npos ? "" : line.substr(space + 1);
  if (word == "accept") {
    reply.kind = Reply::Kind::Accepted;
    reply.output = std::move(rest);
  } else if (word == "refuse") {
    reply.kind = Reply::Kind::Refused;
    reply.message = std::move(rest);
  } else {
    reply.kind = Reply::Kind::Malformed;
    reply.message = fmt::format("answered \"{}\", which is neither `accept JSON` nor `refuse WHY`",
                                plain(line, kQuotedLineBytes));
  }
  return reply;
}

}  // namespace

ServedReader::ServedReader(std::vector<std::string> command, double timeoutSeconds,
                           const std::atomic<bool>* stop)
    : command_(std::move(command)), timeoutSeconds_(timeoutSeconds), stop_(stop) {
  command_.emplace_back("--serve");
}

void ServedReader::restart() {
  process_.reset();
  answered_ = 0;
}

Result<Reply> ServedReader::ask(const std::vector<std::string>& request, const std::string& path) {
  if (path.find('\n') != std::string::npos) {
    return invalid("a path with a line break cannot be sent to a serving reader", path);
  }
  const platform::Stopwatch stopwatch;
  if (!process_) {
    auto started = ChildProcess::start(command_, {.pipeInput = true, .outputBytes = kAnswerBytes});
    if (!started) return started.error();
    process_.emplace(std::move(*started));
  }
  process_->message().clear();
  std::string line;
  for (const std::string& word : request) line += word + " ";
  // If it does not take the line, it exits, closes its pipes or hangs; the wait below tells which.
  const bool sent = process_->send(line + path + "\n");
  const std::string& output = process_->output();
  const auto waited = process_->wait(platform::TimeLimit::ofProcessor(timeoutSeconds_), stop_, [&] {
    return output.find('\n') != std::string::npos || output.size() >= kAnswerBytes ||
           process_->outputClosed();
  });

  Reply reply;
  std::string message = process_->message();
  const std::size_t end = output.find('\n');
  if (waited == ChildProcess::Wait::Stopped) {
    reply.kind = Reply::Kind::Stopped;
  } else if (waited == ChildProcess::Wait::TimedOut) {
    reply.kind = Reply::Kind::TimedOut;
    if (!sent) message += "\n(it did not read the request from standard input)";
  } else if (end != std::string::npos) {
    std::string first = output.substr(0, end);
    process_->output().erase(0, end + 1);
    reply = parsed(first);
  } else if (output.size() >= kAnswerBytes) {
    reply.kind = Reply::Kind::Malformed;
    reply.message = "answered with more than 16 MiB and no end of line";
  } else {
    // It has closed its standard output, so it is most likely exiting.
    constexpr double kPatienceSeconds = 0.5;
    const bool ended = waited == ChildProcess::Wait::Ended ||
                       process_->wait(kPatienceSeconds, stop_) == ChildProcess::Wait::Ended;
    const ProgramRun run = process_->finish();
    message = run.message;
    reply.kind =
        run.end == ProgramRun::End::Signalled ? Reply::Kind::Signalled : Reply::Kind::Exited;
    reply.code = run.code;
    if (!ended) {
      reply.kind = Reply::Kind::Malformed;
      reply.message = "closed its standard output instead of answering";
    }
  }
  if (reply.message.empty()) reply.message = std::move(message);
  reply.seconds = stopwatch.seconds();
  const bool answered = reply.kind == Reply::Kind::Accepted || reply.kind == Reply::Kind::Refused;
  if (answered) {
    ++answered_;
  } else {
    restart();
  }
  return reply;
}

std::optional<std::string> ServedReader::lateFault() {
  if (!process_) return std::nullopt;
  const std::string& output = process_->output();
  const auto waited = process_->wait(0, nullptr, [&] { return !output.empty(); });
  std::optional<std::string> fault;
  if (waited == ChildProcess::Wait::Done) {
    fault = fmt::format("wrote more than one line for this request: \"{}\"",
                        plain(output, kQuotedLineBytes));
  } else if (waited == ChildProcess::Wait::Ended) {
    const ProgramRun run = process_->finish();
    fault = fmt::format(
        "{} {} after its answer, before the end of standard input",
        run.end == ProgramRun::End::Signalled ? "ended by signal" : "ended with exit code",
        run.code);
  }
  if (fault) restart();
  return fault;
}

}  // namespace t4d::conformance
