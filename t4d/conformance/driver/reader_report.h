#pragma once

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "t4d/conformance/driver/reader_suite.h"

/// What came out of putting a reader to its cases, for people and for machines.
namespace t4d::conformance {

/// How many cases had each Outcome.
using OutcomeCounts = std::array<std::size_t, 5>;
OutcomeCounts countsOf(const std::vector<ReaderResult>& results);

/// "valid", "cut": the first part of a case's id.
std::string kindOf(const std::string& id);

/// {reader, corpus_version, passed, failed, crashed, timed_out, skipped, cases: [{id, outcome,
/// message}]}; `reader` is the command as it was given.
nlohmann::ordered_json reportJson(const std::string& reader, const std::vector<ReaderCase>& cases,
                                  const std::vector<ReaderResult>& results);

/// JUnit's XML as continuous integration reads it: a test suite for each kind of case.
std::string reportJunit(const std::string& reader, const std::vector<ReaderCase>& cases,
                        const std::vector<ReaderResult>& results);

/// Text for a terminal: the cases that are not right, at most `most` of them; a table of outcomes
/// by kind of case; and how to look at the first by hand. `command` is what ran the cases, for
/// another time: "t4d conform reader --reader ./my-reader".
std::string reportText(const std::string& reader, const std::string& command,
                       const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results, std::size_t most);

}  // namespace t4d::conformance
