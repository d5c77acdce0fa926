#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "conformance/driver/suite_report.h"
#include "conformance/driver/writer_cases.h"

/// Runs a writer on its cases, and checks the files that it writes.
namespace t4d::conformance {

struct WriterOptions {
  std::vector<std::string> command = {};  ///< from platform::splitCommand
  double timeoutSeconds = 60;             ///< of processor time, per case
  unsigned parallel = 1;                  ///< concurrent processes
  bool first = false;                     ///< stop at the first case that fails
  /// Folder for KIND/NAME.json and KIND/NAME.t4d of the cases that fail; empty for none.
  std::filesystem::path keep = {};
  const std::atomic<bool>* stop = nullptr;  ///< skips the remaining cases when it becomes true
};

/// Calls the writer for each case as COMMAND MESH.json OUT.t4d. OUT.t4d does not exist before.
/// Fails if the writer cannot be started or files cannot be written.
Result<std::vector<CaseReport>> runWriterCases(const std::vector<WriterCase>& cases,
                                               const WriterOptions& options,
                                               const model::Progress& progress = {});

/// What is wrong with a file for the case, one sentence each, the worst first: broken rules of the
/// specification, a different mesh, parts stored more than once. Empty if nothing is wrong.
std::vector<std::string> faultsOf(const WriterCase& test, const std::filesystem::path& file);

/// Text for a terminal: at most `most` of the failed cases, a table of outcomes by kind of case,
/// and how to reproduce the first failure by hand. `command` reruns the cases.
std::string writerReportText(const std::string& writer, const std::string& command,
                             const std::vector<WriterCase>& cases,
                             const std::vector<CaseReport>& reports, std::size_t most);

}  // namespace t4d::conformance
