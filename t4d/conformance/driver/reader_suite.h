#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "t4d/conformance/driver/evaluate.h"
#include "t4d/model/slab.h"

/// Runs a reader over its cases, several at a time.
namespace t4d::conformance {

struct SuiteOptions {
  std::vector<std::string> command;         ///< as from system::splitCommand
  bool serve = false;                       ///< one process for many requests (ServedReader)
  double timeoutSeconds = 10;               ///< of each request
  unsigned parallel = 1;                    ///< requests at a time, each in a process of its own
  bool first = false;                       ///< stop at the first trial that fails
  const std::atomic<bool>* stop = nullptr;  ///< skips the rest when it becomes true
};

struct ReaderResult {
  Outcome outcome = Outcome::Passed;
  std::string message;             ///< of the worst trial that failed, and which others failed
  std::vector<std::size_t> wrong;  ///< the trials that failed, the worst first
  double seconds = 0;              ///< of all its trials
};

/// A result for each case. After a few timeouts the rest of a case is not run; after many, the rest
/// of the suite. A serving reader must give the same results as one that is started for each
/// request: a trial that fails is tried again in a fresh process, and says so if that passes.
/// Errors: the reader cannot be started; temporary files cannot be written.
Result<std::vector<ReaderResult>> runReaderCases(const std::vector<ReaderCase>& cases,
                                                 const SuiteOptions& options,
                                                 const model::Progress& progress = {});

/// Writes the files of the first failed trials of each case into `directory`: ID.t4d as it is in
/// the corpus, or "cut/NAME/cut-to-24-bytes.t4d". Returns the number of files.
Result<std::size_t> keepWrongFiles(const std::vector<ReaderCase>& cases,
                                   const std::vector<ReaderResult>& results,
                                   const std::filesystem::path& directory);

/// Where keepWrongFiles writes the file of a trial.
std::filesystem::path keptFile(const ReaderCase& test, const Trial& trial);

}  // namespace t4d::conformance
