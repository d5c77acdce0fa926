#include "t4d/system/child_process.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "t4d/system/cleanup.h"

namespace t4d::system {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Longest wait between two looks at RunLimits::stop.
constexpr int kLookMilliseconds = 100;

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return number_; }
  void reset(int number = -1) {
    if (number_ >= 0) close(number_);
    number_ = number;
  }

 private:
  int number_;
};

tl::unexpected<Error> cannot(const std::string& what, int reason) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", what, std::strerror(reason)));
}

/// One of the program's streams, and what has come out of it.
class Stream {
 public:
  Stream(std::string& text, std::size_t most) : text_(text), most_(most) {}

  Result<void> open() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return cannot("make a pipe", errno);
    ours_.reset(ends[0]);
    theirs_.reset(ends[1]);
    if (fcntl(ours_.get(), F_SETFL, O_NONBLOCK) != 0) return cannot("set up a pipe", errno);
    return {};
  }
  int ours() const { return ours_.get(); }
  int theirs() const { return theirs_.get(); }
  void closeTheirs() { theirs_.reset(); }

  /// Takes what is there. Closes our end where no more can come.
  void drain() {
    std::array<char, 65536> buffer;
    while (ours_.get() >= 0) {
      const ssize_t size = read(ours_.get(), buffer.data(), buffer.size());
      if (size < 0 && errno == EINTR) continue;
      if (size < 0 && errno == EAGAIN) return;
      if (size <= 0) return ours_.reset();
      text_.append(buffer.data(), std::min(static_cast<std::size_t>(size), most_ - text_.size()));
    }
  }

 private:
  Descriptor ours_;
  Descriptor theirs_;
  std::string& text_;
  std::size_t most_;
};

/// What a process is started with: its streams, a group of its own, no signal blocked or ignored,
/// nothing else of ours open.
class Spawning {
 public:
  Spawning(const Stream& output, const Stream& message) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output.theirs(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, message.theirs(), STDERR_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
    posix_spawnattr_init(&attributes_);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes_, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~Spawning() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  Spawning(const Spawning&) = delete;
  Spawning& operator=(const Spawning&) = delete;

  /// 0, or why not.
  int start(std::vector<std::string> words, pid_t& child) const {
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    return posix_spawn(&child, words[0].c_str(), &actions_, &attributes_, arguments.data(),
                       environ);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

tl::unexpected<Error> cannotStart(const std::string& path, int reason) {
  std::string why = std::strerror(reason);
  if (reason == ENOEXEC) {
    why += "; a script begins with a line like #!/usr/bin/env python3";
  } else if (reason == ENOENT && fs::exists(path)) {
    why = "the interpreter that its first line names is not there";
  }
  const bool busy = reason == EAGAIN || reason == ENOMEM;
  return fail(busy ? ErrorCode::Failed : ErrorCode::InvalidInput, "cannot be started: " + why,
              path);
}

/// Waits for the process to end while taking what it prints. Returns why we must end it, if so.
std::optional<ProgramRun::End> watch(int process, Stream& output, Stream& message,
                                     const RunLimits& limits) {
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(limits.seconds));
  while (true) {
    std::array<pollfd, 3> waiting = {
        pollfd{process, POLLIN, 0}, {output.ours(), POLLIN, 0}, {message.ours(), POLLIN, 0}};
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return ProgramRun::End::TimedOut;
    const int wait = left < kLookMilliseconds ? static_cast<int>(left) + 1 : kLookMilliseconds;
    poll(waiting.data(), waiting.size(), wait);
    if (waiting[1].revents != 0) output.drain();
    if (waiting[2].revents != 0) message.drain();
    if (waiting[0].revents != 0) return std::nullopt;
    if (limits.stop != nullptr && *limits.stop) return ProgramRun::End::Stopped;
  }
}

bool executable(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

/// The words of a command line. An error is an open quote.
Result<std::vector<std::string>> wordsOf(const std::string& text) {
  std::vector<std::string> words;
  std::optional<std::string> word;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool blank = c == ' ' || c == '\t' || c == '\n';
    if (quote == 0 && blank) {
      if (word) words.push_back(*std::exchange(word, std::nullopt));
      continue;
    }
    if (!word) word.emplace();
    if (c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
    } else if (c == '\\' && quote != '\'' && i + 1 < text.size()) {
      *word += text[++i];
    } else {
      *word += c;
    }
  }
  if (quote != 0) return invalid(fmt::format("the quote {} is not closed", quote), text);
  if (word) words.push_back(*word);
  if (words.empty()) return invalid("the command is empty");
  return words;
}

}  // namespace

Result<std::vector<std::string>> readerCommand(const std::string& text) {
  std::error_code error;
  if (text.find('/') != std::string::npos && executable(text)) return std::vector{text};
  auto words = wordsOf(text);
  if (!words) return words;
  std::string& program = words->front();
  if (program.find('/') != std::string::npos) {
    if (executable(program)) return words;
    if (!fs::exists(program, error)) return invalid("is not there", program);
    if (!fs::is_regular_file(program, error)) return invalid("is not a file", program);
    return invalid(
        fmt::format("is not executable: `chmod +x {}` makes it so, or name what runs it, "
                    "as in 'python3 {}'",
                    program, program),
        program);
  }
  const char* path = std::getenv("PATH");
  std::string_view folders = path == nullptr ? "" : path;
  while (!folders.empty()) {
    const std::size_t colon = folders.find(':');
    const fs::path found = fs::path(folders.substr(0, colon)) / program;
    if (executable(found)) {
      program = found.string();
      return words;
    }
    folders = colon == std::string_view::npos ? "" : folders.substr(colon + 1);
  }
  return invalid(fs::exists(program, error)
                     ? fmt::format("is not in PATH; the file in this folder is ./{}", program)
                     : "is not in PATH",
                 program);
}

Result<ProgramRun> runProgram(const std::vector<std::string>& words, const RunLimits& limits) {
  ProgramRun run;
  Stream output(run.output, limits.outputBytes);
  Stream message(run.message, limits.outputBytes);
  if (auto open = output.open(); !open) return pass(open.error());
  if (auto open = message.open(); !open) return pass(open.error());
  const auto begun = Clock::now();
  pid_t child = 0;
  if (const int failed = Spawning(output, message).start(words, child); failed != 0) {
    return cannotStart(words[0], failed);
  }
  Cleanup note = Cleanup::process(-child);
  output.closeTheirs();
  message.closeTheirs();

  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
  const int noDescriptor = errno;
  std::optional<ProgramRun::End> ended = ProgramRun::End::Stopped;
  if (process.get() >= 0) ended = watch(process.get(), output, message, limits);
  // Before it is waited for: then the number of its group cannot be another's.
  kill(-child, SIGKILL);
  note.release();
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (process.get() < 0) return cannot("watch a process", noDescriptor);
  output.drain();
  message.drain();
  run.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  if (ended) {
    run.end = *ended;
  } else if (WIFSIGNALED(status)) {
    run.end = ProgramRun::End::Signalled;
    run.code = WTERMSIG(status);
  } else {
    run.code = WEXITSTATUS(status);
  }
  return run;
}

}  // namespace t4d::system
