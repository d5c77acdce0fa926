#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include "t4d/model/error.h"

/// Runs other programs, and reports how they end whatever they do.
namespace t4d::system {

/// How long a program may take.
struct TimeLimit {
  // NOLINTNEXTLINE(google-explicit-constructor): a number of seconds is a limit
  TimeLimit(double bySeconds = std::numeric_limits<double>::infinity()) : seconds(bySeconds) {}
  /// `seconds` of processor time, however busy the machine is; ten times that by the clock, so that
  /// a program that sleeps ends, too.
  static TimeLimit ofProcessor(double seconds);

  double seconds;  ///< by the clock
  /// Of the processor, by the program and the processes of its group. Not before as many seconds
  /// have passed by the clock: a program may work with many threads.
  double processorSeconds = std::numeric_limits<double>::infinity();
};

struct RunOptions {
  TimeLimit limit = {};
  std::size_t outputBytes = std::size_t{16} << 20;  ///< kept of each stream; the rest is dropped
  /// The program is killed when this becomes true.
  const std::atomic<bool>* stop = nullptr;
  /// False: it writes to the standard error of this process instead of ProgramRun::message.
  bool captureMessage = true;
};

/// How a program ended.
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
  std::uint64_t peakBytes = 0;  ///< of memory, as the system counts it
};

/// Splits a command as a user types it, "python3 my_reader.py --fast", into words. Quotes and
/// backslashes work as in a shell; a text that is the path of an executable file is one word. The
/// first word is returned as a path, looked up in PATH as a shell does. Errors: the program does
/// not exist, or is not executable.
Result<std::vector<std::string>> splitCommand(const std::string& text);

/// Runs `words[0]`, a path, with the other words as arguments, in a process group of its own and
/// with an empty standard input. Processes that it leaves behind in its group are killed. Safe to
/// call from many threads. Errors: the program cannot be started.
Result<ProgramRun> runProgram(const std::vector<std::string>& words,
                              const RunOptions& options = {});

/// Runs this program again with other arguments, sharing standard error. Errors: it cannot be
/// started, or a signal ended it.
Result<ProgramRun> runSelf(const std::vector<std::string>& arguments);

/// A program that runs while this one talks to it or watches it. runProgram is all that most
/// callers need.
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
  /// Kills it and its process group.
  ~ChildProcess();

  /// What it has printed so far and nobody has taken out. At most Options::outputBytes each; what
  /// it prints beyond that is dropped.
  std::string& output();
  std::string& message();
  bool outputClosed() const;
  pid_t pid() const;

  /// Writes to its standard input. False if it does not take all of the text at once: it has closed
  /// its standard input, has ended, or has not read what was sent before.
  bool send(const std::string& text);

  enum class Wait : std::uint8_t { Done, Ended, TimedOut, Stopped };
  /// Collects output until `done` returns true, the process has ended, the time from now on is over
  /// or `stop` becomes true. With 0 seconds it takes what is there.
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

}  // namespace t4d::system
