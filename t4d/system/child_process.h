#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "t4d/model/error.h"

/// Runs somebody's program and says how it ended, whatever it does.
namespace t4d::system {

struct RunLimits {
  double seconds = 10;
  std::size_t outputBytes = std::size_t{16} << 20;  ///< of each stream; what is more is dropped
  /// Where this becomes true the program is ended.
  const std::atomic<bool>* stop = nullptr;
};

/// How a program ended.
struct ProgramRun {
  enum class End : std::uint8_t {
    Exited,     ///< with the exit code `code`
    Signalled,  ///< by the signal `code`
    TimedOut,   ///< by us, after RunLimits::seconds
    Stopped,    ///< by us, as RunLimits::stop said
  };
  End end = End::Exited;
  int code = 0;
  std::string output;   ///< standard output
  std::string message;  ///< standard error
  double seconds = 0;   ///< from start to end
};

/// The words of a command as a user gives it, "python3 my_reader.py --fast": quotes and backslashes
/// are a shell's; a text that is the path of a file is one word. The first word comes back as a
/// path, found as a shell finds it. Errors: it is not there, or cannot be executed.
Result<std::vector<std::string>> readerCommand(const std::string& text);

/// Runs `words[0]`, a path, with the other words as arguments, in a process group of its own and
/// with an empty standard input. Whatever it has started and left behind is ended with it. Any
/// number may run at a time, from any threads. Errors: it cannot be started.
Result<ProgramRun> runProgram(const std::vector<std::string>& words, const RunLimits& limits = {});

}  // namespace t4d::system
