#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "conformance/driver/suite_report.h"
#include "t4d/error.h"

/// Shared by the verbs that run readers and writers under test.
namespace t4d::tools {

/// The options that they have in common.
struct ConformArguments {
  std::vector<std::string> only = {};
  std::vector<std::string> skip = {};
  unsigned parallel = 1;
  double timeoutSeconds = 0;
  std::string junit = {};
  std::string keep = {};
  bool first = false;
  bool verbose = false;
  bool json = false;
};

/// The words in which their help differs.
struct ConformHelp {
  std::string tested;   ///< "reader" or "writer"
  std::string only;     ///< what may be chosen: "globs or folders ('cut')"
  std::string timeout;  ///< of what: "request"
  std::string keep;
  std::string cases;   ///< how the ids of cases begin, as an expression: "valid|cut"
  std::string report;  ///< what the report is
};

inline constexpr const char* kVersionPattern = "^[0-9]+\\.[0-9]+\\.[0-9]+$";

/// Adds these options; `arguments.timeoutSeconds` is the default.
void addConformOptions(CLI::App& command, ConformArguments& arguments, const ConformHelp& help);

/// Reports a run that could not be made. Returns the exit code.
int reportNoRun(const Error& error);

/// Writes and prints what the options ask for. `tested` is "reader" or "writer", `program` its
/// command; `text` returns the report for a terminal with at most the given number of failed cases.
/// Returns the exit code.
int reportRun(const std::string& tested, const std::string& program,
              const ConformArguments& arguments,
              const std::vector<conformance::CaseReport>& reports,
              const std::function<std::string(std::size_t most)>& text);

}  // namespace t4d::tools
