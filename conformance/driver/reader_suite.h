#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "conformance/driver/evaluate.h"
#include "t4d/mesh.h"

/// Runs a reader on its cases, several at a time.
namespace t4d::conformance {

struct SuiteOptions {
  std::vector<std::string> command = {};    ///< from platform::splitCommand
  bool serve = false;                       ///< one process for many requests (ServedReader)
  double timeoutSeconds = 10;               ///< of processor time, per request
  unsigned parallel = 1;                    ///< concurrent requests, each in its own process
  bool first = false;                       ///< stop at the first trial that fails
  const std::atomic<bool>* stop = nullptr;  ///< skips the remaining trials when it becomes true
};

struct ReaderResult {
  Outcome outcome = Outcome::Passed;
  std::string message;             ///< describes the worst failed trial, and lists the other ones
  std::vector<std::size_t> wrong;  ///< the failed trials, worst first
  double seconds = 0;              ///< total of all its trials
};

/// Returns one result per case. After a few timeouts the rest of a case is skipped; after many, the
/// rest of the suite. A serving reader must give the same results as one that is started for each
/// request: a failed trial is repeated in a fresh process, and reported as such if it then passes.
/// Fails if the reader cannot be started or temporary files cannot be written.
Result<std::vector<ReaderResult>> runReaderCases(const std::vector<ReaderCase>& cases,
                                                 const SuiteOptions& options,
                                                 const model::Progress& progress = {});

/// Writes the files of the first failed trials of each case into `directory`: the corpus file as
/// ID.t4d, or for example "cut/NAME/cut-to-24-bytes.t4d". Returns the number of files.
Result<std::size_t> keepWrongFiles(const std::vector<ReaderCase>& cases,
                                   const std::vector<ReaderResult>& results,
                                   const std::filesystem::path& directory);

/// The path that keepWrongFiles uses for the file of a trial.
std::filesystem::path keptFile(const ReaderCase& test, const Trial& trial);

}  // namespace t4d::conformance
