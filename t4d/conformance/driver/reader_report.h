#pragma once

#include <array>
#include <string>
#include <vector>

#include "t4d/conformance/driver/reader_suite.h"

/// Reports the results of a reader, for people and for programs.
namespace t4d::conformance {

/// Number of cases with each Outcome.
using OutcomeCounts = std::array<std::size_t, 5>;
OutcomeCounts countsOf(const std::vector<ReaderResult>& results);

/// "valid", "cut": the first part of a case's id.
std::string kindOf(const std::string& id);

/// JSON: {reader, corpus_version, passed, failed, crashed, timed_out, skipped, cases: [{id,
/// outcome, message}]}; `reader` is the command as it was given.
std::string reportJson(const std::string& reader, const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results);

/// JUnit XML, for continuous integration: a test suite for each kind of case.
std::string reportJunit(const std::string& reader, const std::vector<ReaderCase>& cases,
                        const std::vector<ReaderResult>& results);

/// Text for a terminal: at most `most` of the failed cases, a table of outcomes by kind of case,
/// and how to reproduce the first failure by hand. `command` reruns the cases, for example "t4d
/// conform reader --reader ./my-reader"; `serve` as in SuiteOptions.
std::string reportText(const std::string& reader, const std::string& command, bool serve,
                       const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results, std::size_t most);

}  // namespace t4d::conformance
