#pragma once

#include <string>

#include "conformance/driver/reader_cases.h"
#include "platform/child_process.h"

namespace t4d::conformance {

/// Outcomes from best to worst.
enum class Outcome : std::uint8_t {
  Passed,
  Skipped,
  Failed,  ///< accepted or refused the wrong file, or gave a wrong answer
  TimedOut,
  Crashed,  ///< ended by a signal, or in a way that the protocol does not define
};

/// "passed", "timed_out".
const char* nameOf(Outcome outcome);

/// The reaction of a reader to a request.
struct Reply {
  enum class Kind : std::uint8_t {
    Accepted,
    Refused,
    Malformed,  ///< it violated the protocol of a serving reader; `message` says how
    Exited,     ///< without a reply, with the exit code `code`
    Signalled,  ///< by the signal `code`
    TimedOut,
    Stopped,  ///< by us, on request
  };
  Kind kind = Kind::Accepted;
  int code = 0;
  std::string output;   ///< the answer, if the reader accepts
  std::string message;  ///< its standard error, or why it refused
  double seconds = 0;
};

/// The reply of a reader that was started for one request: exit code 0 accepts, 1 refuses.
Reply replyOf(platform::ProgramRun run);

struct TrialResult {
  Outcome outcome = Outcome::Passed;
  std::string message;  ///< what is wrong, for the author of the reader; empty if it passed
  double seconds = 0;
};

/// Compares a reply with the requirements of the trial. `path` is the file given to the reader,
/// called FILE in messages; `timeoutSeconds` is its limit of processor time.
TrialResult evaluate(const Trial& trial, const Reply& reply, const std::string& path,
                     double timeoutSeconds);

}  // namespace t4d::conformance
