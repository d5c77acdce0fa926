#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "t4d/conformance/driver/evaluate.h"
#include "t4d/model/slab.h"

/// Puts a reader to its cases, several at a time.
namespace t4d::conformance {

struct SuiteOptions {
  std::vector<std::string> command;         ///< of readerCommand
  double seconds = 10;                      ///< how long a start may take
  unsigned parallel = 1;                    ///< starts at a time
  bool first = false;                       ///< end at the first start that is not right
  const std::atomic<bool>* stop = nullptr;  ///< where it becomes true, what is left is skipped
};

struct ReaderResult {
  Outcome outcome = Outcome::Passed;
  std::string message;  ///< of the worst trial that is not right, and which others are not
  std::vector<std::size_t> wrong;  ///< the trials that are not right, the worst first
  double seconds = 0;              ///< that its starts took together
};

/// A result for each case. A case is left after some starts that took too long; where that goes on,
/// so are all that have not been run. Errors: the reader cannot be started; no temporary files can
/// be written.
Result<std::vector<ReaderResult>> runReaderCases(const std::vector<ReaderCase>& cases,
                                                 const SuiteOptions& options,
                                                 const model::Progress& progress = {});

/// Writes the files of the first wrong trials of each case into `directory`: ID.t4d as it is in the
/// corpus, or "cut/NAME/cut-to-24-bytes.t4d". Returns how many.
Result<std::size_t> keepWrongFiles(const std::vector<ReaderCase>& cases,
                                   const std::vector<ReaderResult>& results,
                                   const std::filesystem::path& directory);

/// Where keepWrongFiles writes the file of a trial.
std::filesystem::path keptFile(const ReaderCase& test, const Trial& trial);

}  // namespace t4d::conformance
