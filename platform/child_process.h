#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "t4d/error.h"

/// Runs other programs, and reports how they ended, whatever they do.
namespace t4d::platform {

/// The time that a program may take.
struct TimeLimit {
  // NOLINTNEXTLINE(google-explicit-constructor): a number of seconds is a limit
  TimeLimit(double bySeconds = std::numeric_limits<double>::infinity()) : seconds(bySeconds) {}
  /// A limit of `seconds` of processor time, however busy the machine is, and of ten times that by
  /// the clock, which ends programs that sleep.
  static TimeLimit ofProcessor(double seconds);

  double seconds;  ///< by the clock
  /// Limit of the program's processor time, without that of other programs that it starts. It takes
  /// effect only after this many seconds by the clock, since a program may use many threads.
  double processorSeconds = std::numeric_limits<double>::infinity();
};

struct RunOptions {
  TimeLimit limit = {};
  std::size_t outputBytes = std::size_t{16} << 20;  ///< kept of each stream; the rest is dropped
  /// The program is killed when this becomes true.
  const std::atomic<bool>* stop = nullptr;
  /// If false, its standard error is that of this process, and ProgramRun::message is empty.
  bool captureMessage = true;
};

/// The end of a program, and its output.
struct ProgramRun {
  enum class End : std::uint8_t {
    Exited,     ///< with the exit code `code`
    Signalled,  ///< by the signal `code`
    TimedOut,   ///< killed after RunOptions::limit
    Stopped,    ///< killed because of RunOptions::stop
  };
  End end = End::Exited;
  int code = 0;
  std::string output;           ///< standard output
  std::string message;          ///< standard error
  double seconds = 0;           ///< from start to end
  double processorSeconds = 0;  ///< of all its threads, and of programs that it waited for
  std::uint64_t peakBytes = 0;  ///< peak memory, as counted by the system
};

/// Splits a command as a user types it, "python3 my_reader.py --fast", into words. Quotes and
/// backslashes work as in a shell; a text that is the path of an executable file is one word. The
/// first word is returned as a path, looked up in PATH as a shell does. Fails if the program does
/// not exist or is not executable.
Result<std::vector<std::string>> splitCommand(const std::string& text);

/// Runs `words[0]`, a path, with the other words as arguments, in a process group of its own and
/// with an empty standard input. Processes that it leaves behind in its group are killed. Safe to
/// call from many threads. Fails if the program cannot be started.
Result<ProgramRun> runProgram(const std::vector<std::string>& words,
                              const RunOptions& options = {});

/// Runs this program again with other arguments, sharing standard error. Fails if it cannot be
/// started, or if a signal ended it.
Result<ProgramRun> runSelf(const std::vector<std::string>& arguments);

/// Starts a program, looked up in PATH, that goes on when this one ends. It has no streams, and
/// nothing tells whether it could be started.
void startDetached(std::vector<std::string> words);

/// A program that runs while this one communicates with it or watches it. Most callers only need
/// runProgram.
class ChildProcess {
 public:
  struct Options {
    bool pipeInput = false;  ///< `send` writes to its standard input; empty otherwise
    bool captureMessage = true;
    std::size_t outputBytes = RunOptions{}.outputBytes;
  };

  /// Starts it in a process group of its own, as runProgram does.
  static Result<ChildProcess> start(const std::vector<std::string>& words, const Options& options);
  ChildProcess(ChildProcess&&) noexcept;
  ChildProcess& operator=(ChildProcess&&) noexcept;
  /// Kills the program and its process group.
  ~ChildProcess();

  /// The output that the caller has not yet taken: at most Options::outputBytes for each stream;
  /// the rest is dropped.
  std::string& output();
  std::string& message();
  bool outputClosed() const;
  int pid() const;

  /// Writes to its standard input. False if it does not take the whole text at once, because it has
  /// closed its standard input, has ended, or has not read earlier text.
  bool send(const std::string& text);

  enum class Wait : std::uint8_t { Done, Ended, TimedOut, Stopped };
  /// Collects output until `done` returns true, the process has ended, the limit (from now on) is
  /// reached, or `stop` becomes true. With 0 seconds it takes the output that is available.
  Wait wait(const TimeLimit& limit, const std::atomic<bool>* stop = nullptr,
            const std::function<bool()>& done = {});

  /// Kills what is left of its process group and returns how the process ended: by its own exit or
  /// signal if it had ended before, killed (Signalled, SIGKILL) otherwise. Call it once.
  ProgramRun finish();

 private:
  struct State;
  explicit ChildProcess(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace t4d::platform
