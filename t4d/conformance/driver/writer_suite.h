#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "t4d/conformance/driver/suite_report.h"
#include "t4d/conformance/driver/writer_cases.h"

/// Runs a writer over its cases, and judges the files that it makes.
namespace t4d::conformance {

struct WriterOptions {
  std::vector<std::string> command = {};  ///< from system::splitCommand
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

/// What is wrong with a file as a file of the case, a sentence each, the worst first: rules of the
/// specification, the mesh, how often parts of it are stored. Empty if nothing is.
std::vector<std::string> faultsOf(const WriterCase& test, const std::filesystem::path& file);

/// Text for a terminal: at most `most` of the failed cases, a table of outcomes by kind of case,
/// and how to reproduce the first failure by hand. `command` reruns the cases.
std::string writerReportText(const std::string& writer, const std::string& command,
                             const std::vector<WriterCase>& cases,
                             const std::vector<CaseReport>& reports, std::size_t most);

}  // namespace t4d::conformance
