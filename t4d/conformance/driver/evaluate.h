#pragma once

#include <string>

#include "t4d/conformance/driver/reader_cases.h"
#include "t4d/system/child_process.h"

namespace t4d::conformance {

/// From right to worst.
enum class Outcome : std::uint8_t {
  Passed,
  Skipped,
  Failed,  ///< it accepted what it must refuse or the other way round, or its answer is wrong
  TimedOut,
  Crashed,  ///< ended by a signal, or with an exit code other than 0 and 1
};

/// "passed", "timed_out".
const char* nameOf(Outcome outcome);

struct TrialResult {
  Outcome outcome = Outcome::Passed;
  std::string message;  ///< what is wrong, for the author of the reader; empty if it passed
  double seconds = 0;
};

/// Compares a run of the reader with what the trial requires. `path` is the file that it was given,
/// called FILE in messages; `timeoutSeconds` the limit of the run.
TrialResult evaluate(const Trial& trial, const system::ProgramRun& run, const std::string& path,
                     double timeoutSeconds);

}  // namespace t4d::conformance
