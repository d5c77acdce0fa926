#pragma once

#include <string>
#include <vector>

#include "conformance/driver/reader_suite.h"
#include "conformance/driver/suite_report.h"

/// Reports the results of a reader.
namespace t4d::conformance {

std::vector<CaseReport> reportsOf(const std::vector<ReaderCase>& cases,
                                  const std::vector<ReaderResult>& results);

/// Text for a terminal: at most `most` of the failed cases, a table of outcomes by kind of case,
/// and how to reproduce the first failure by hand. `command` reruns the cases, for example "t4d
/// conform reader --reader ./my-reader"; `serve` as in SuiteOptions.
std::string reportText(const std::string& reader, const std::string& command, bool serve,
                       const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results, std::size_t most);

}  // namespace t4d::conformance
