#include "platform/child_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "platform/cleanup.h"
#include "platform/descriptor.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Longest wait between two looks at RunOptions::stop.
constexpr int kLookMilliseconds = 100;

Error cannot(const std::string& what, int reason) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", what, std::strerror(reason)));
}

/// One of the program's streams, and what has come out of it.
class Stream {
 public:
  Stream(std::string& text, std::size_t most) : text_(text), most_(most) {}

  Result<void> open() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return cannot("make a pipe", errno);
    ours_ = Descriptor(ends[0]);
    theirs_ = Descriptor(ends[1]);
    if (fcntl(ours_.number(), F_SETFL, O_NONBLOCK) != 0) return cannot("set up a pipe", errno);
    return {};
  }
  int ours() const { return ours_.number(); }
  int theirs() const { return theirs_.number(); }
  void closeTheirs() { theirs_.close(); }

  /// Takes what is there, up to more than a pipe can hold: a program may write faster than we read.
  /// Closes our end where no more can come.
  void drain() {
    constexpr int kReads = 32;
    std::array<char, 65536> buffer;
    for (int reads = 0; reads < kReads && ours_; ++reads) {
      const auto size = ours_.read(std::as_writable_bytes(std::span(buffer)));
      if (size < 0 && errno == EAGAIN) return;
      if (size <= 0) {
        ours_.close();
        return;
      }
      const std::size_t room = most_ - std::min(most_, text_.size());
      text_.append(buffer.data(), std::min(static_cast<std::size_t>(size), room));
    }
  }

 private:
  Descriptor ours_;
  Descriptor theirs_;
  std::string& text_;
  std::size_t most_;
};

/// The arguments as the system takes them: pointers into `words`, and a null.
std::vector<char*> argumentsOf(std::vector<std::string>& words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return arguments;
}

/// How a process is started: its streams, a group of its own, no signal blocked or ignored, and
/// no other descriptor of ours open.
class Spawning {
 public:
  /// Each argument is a descriptor; -1 for `message` means that it shares ours.
  Spawning(int input, int output, int message) {
    posix_spawn_file_actions_init(&actions_);
    if (input >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    } else {
      posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    }
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    if (message >= 0) posix_spawn_file_actions_adddup2(&actions_, message, STDERR_FILENO);
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
    return posix_spawn(&child, words[0].c_str(), &actions_, &attributes_, argumentsOf(words).data(),
                       environ);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

Error cannotStart(const std::string& path, int reason) {
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

/// Blocks SIGPIPE in this thread, and forgets those that arrived.
class WithoutSigpipe {
 public:
  WithoutSigpipe() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGPIPE);
    sigset_t pending;
    sigemptyset(&pending);
    sigpending(&pending);
    wasPending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &set_, &before_);
  }
  ~WithoutSigpipe() {
    const timespec none{};
    if (!wasPending_) {
      while (sigtimedwait(&set_, nullptr, &none) < 0 && errno == EINTR) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  WithoutSigpipe(const WithoutSigpipe&) = delete;
  WithoutSigpipe& operator=(const WithoutSigpipe&) = delete;

 private:
  sigset_t set_{};
  sigset_t before_{};
  bool wasPending_ = false;
};

/// The processor time of a process so far, of all its threads; 0 once it has ended.
double processorSecondsOf(pid_t process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
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

Result<std::vector<std::string>> splitCommand(const std::string& text) {
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

struct ChildProcess::State {
  explicit State(const Options& options)
      : output(run.output, options.outputBytes), message(run.message, options.outputBytes) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { reap(); }

  /// Kills the process group and waits for the process; returns its status.
  int reap() {
    if (child == 0) return 0;
    // Before it is waited for: until then no other group can have its number.
    kill(-child, SIGKILL);
    note.release();
    int status = 0;
    rusage usage{};
    while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    child = 0;
    const auto secondsOf = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    run.processorSeconds = secondsOf(usage.ru_utime) + secondsOf(usage.ru_stime);
    run.peakBytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
    return status;
  }

  ProgramRun run;
  Stream output;
  Stream message;
  Descriptor input;
  pid_t child = 0;
  Cleanup note;
  Descriptor process;
  Clock::time_point begun;
};

ChildProcess::ChildProcess(std::unique_ptr<State> state) : state_(std::move(state)) {}
ChildProcess::ChildProcess(ChildProcess&&) noexcept = default;
ChildProcess& ChildProcess::operator=(ChildProcess&&) noexcept = default;
ChildProcess::~ChildProcess() = default;

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words,
                                         const Options& options) {
  auto state = std::make_unique<State>(options);
  if (auto open = state->output.open(); !open) return open.error();
  if (options.captureMessage) {
    if (auto open = state->message.open(); !open) return open.error();
  }
  Descriptor theirInput;
  if (options.pipeInput) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return cannot("make a pipe", errno);
    theirInput = Descriptor(ends[0]);
    state->input = Descriptor(ends[1]);
    if (fcntl(ends[1], F_SETFL, O_NONBLOCK) != 0) return cannot("set up a pipe", errno);
  }
  const Spawning spawning(theirInput.number(), state->output.theirs(), state->message.theirs());
  state->begun = Clock::now();
  {
    const HeldCleanup held;
    pid_t child = 0;
    if (const int failed = spawning.start(words, child); failed != 0) {
      return cannotStart(words[0], failed);
    }
    state->child = child;
    state->note = Cleanup::process(held, -child);
  }
  state->output.closeTheirs();
  state->message.closeTheirs();
  state->process = Descriptor(static_cast<int>(syscall(SYS_pidfd_open, state->child, 0)));
  if (!state->process) return cannot("watch a process", errno);
  return ChildProcess(std::move(state));
}

std::string& ChildProcess::output() { return state_->run.output; }
std::string& ChildProcess::message() { return state_->run.message; }
bool ChildProcess::outputClosed() const { return state_->output.ours() < 0; }
int ChildProcess::pid() const { return state_->child; }

bool ChildProcess::send(const std::string& text) {
  const WithoutSigpipe quiet;
  return state_->input.write(text);
}

TimeLimit TimeLimit::ofProcessor(double seconds) {
  constexpr double kByTheClock = 10;
  TimeLimit limit(kByTheClock * seconds);
  limit.processorSeconds = seconds;
  return limit;
}

ChildProcess::Wait ChildProcess::wait(const TimeLimit& limit, const std::atomic<bool>* stop,
                                      const std::function<bool()>& done) {
  const auto begun = Clock::now();
  const bool counts = std::isfinite(limit.processorSeconds);
  const double before = counts ? processorSecondsOf(state_->child) : 0;
  while (true) {
    std::array<pollfd, 3> waiting = {pollfd{state_->process.number(), POLLIN, 0},
                                     {state_->output.ours(), POLLIN, 0},
                                     {state_->message.ours(), POLLIN, 0}};
    const double passed = std::chrono::duration<double>(Clock::now() - begun).count();
    const bool late = passed >= limit.seconds ||
                      (passed >= limit.processorSeconds &&
                       processorSecondsOf(state_->child) - before >= limit.processorSeconds);
    const double left = 1000 * (std::min(limit.seconds, limit.processorSeconds) - passed);
    const int wait = late       ? 0
                     : left > 0 ? static_cast<int>(std::min(left + 1, double{kLookMilliseconds}))
                                : kLookMilliseconds;
    poll(waiting.data(), waiting.size(), wait);
    // Whatever it wrote before it ended is there when its end can be seen.
    state_->output.drain();
    state_->message.drain();
    if (done && done()) return Wait::Done;
    if (waiting[0].revents != 0) return Wait::Ended;
    if (stop != nullptr && *stop) return Wait::Stopped;
    if (late) return Wait::TimedOut;
  }
}

ProgramRun ChildProcess::finish() {
  const int status = state_->reap();
  state_->output.drain();
  state_->message.drain();
  ProgramRun run = std::move(state_->run);
  run.seconds = std::chrono::duration<double>(Clock::now() - state_->begun).count();
  run.end = WIFSIGNALED(status) ? ProgramRun::End::Signalled : ProgramRun::End::Exited;
  run.code = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
  return run;
}

Result<ProgramRun> runProgram(const std::vector<std::string>& words, const RunOptions& options) {
  auto child = ChildProcess::start(
      words, {.captureMessage = options.captureMessage, .outputBytes = options.outputBytes});
  if (!child) return child.error();
  const auto waited = child->wait(options.limit, options.stop);
  ProgramRun run = child->finish();
  if (waited == ChildProcess::Wait::TimedOut) run.end = ProgramRun::End::TimedOut;
  if (waited == ChildProcess::Wait::Stopped) run.end = ProgramRun::End::Stopped;
  return run;
}

Result<ProgramRun> runSelf(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"/proc/self/exe"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  auto run = runProgram(words, {.captureMessage = false});
  if (run && run->end == ProgramRun::End::Signalled) {
    return fail(
        ErrorCode::Failed,
        fmt::format("`{} {}` was ended by signal {}{}", program_invocation_short_name,
                    arguments.front(), run->code, run->code == SIGKILL ? " (out of memory?)" : ""));
  }
  return run;
}

void startDetached(std::vector<std::string> words) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  pid_t pid = 0;
  posix_spawnp(&pid, words[0].c_str(), &files, &attributes, argumentsOf(words).data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
}

}  // namespace t4d::platform
