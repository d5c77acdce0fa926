#pragma once

#include <array>
#include <string>
#include <vector>

#include "conformance/driver/evaluate.h"

/// Reports the results of readers and writers, for people and for programs.
namespace t4d::conformance {

/// A case in a report.
struct CaseReport {
  std::string id;
  Outcome outcome = Outcome::Passed;
  std::string message = {};  ///< what is wrong, or why it was skipped; empty if it passed
  double seconds = 0;

  bool isWrong() const { return outcome != Outcome::Passed && outcome != Outcome::Skipped; }
};

/// Number of cases with each Outcome.
using OutcomeCounts = std::array<std::size_t, 5>;
OutcomeCounts countsOf(const std::vector<CaseReport>& cases);

/// "valid", "cut": the first part of a case's id.
std::string kindOf(const std::string& id);

/// JUnit XML, for continuous integration: a test suite for each kind of case.
std::string reportJunit(const std::string& tested, const std::string& command,
                        const std::vector<CaseReport>& cases);

/// The outcomes by kind of case, and why cases were skipped.
std::string outcomeTable(const std::vector<CaseReport>& cases);

/// A failed case: its outcome and id, what it is about (unless empty), and what is wrong.
std::string failureText(const CaseReport& test, const std::string& about);

}  // namespace t4d::conformance
