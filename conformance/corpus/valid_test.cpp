#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/expect_answers.h"
#include "platform/test_folder.h"
#include "tools/t4d/validation.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;

double numberOf(const json& text) { return std::strtod(text.get<std::string>().c_str(), nullptr); }

/// The sum of a member over the bodies of an answer, or of its tolerances.
double sumOf(const std::string& text, const char* member) {
  double sum = 0;
  const json parsed = json::parse(text);
  for (const json& body : parsed.is_array() ? parsed : parsed["bodies"])
    sum += numberOf(body[member]);
  return sum;
}

TEST(ValidFiles, AreReadByOurReaderAsTheyMustBe) {
  for (const AcceptedCase& made : validCases()) {
    SCOPED_TRACE(made.file.id);
    const platform::TestFolder folder;
    const auto file = folder.write("file.t4d", made.file.bytes);
    const auto description = describeFile(file);
    ASSERT_TRUE(description) << description.error().text();
    expectAnswers(made.file, file, *description);
  }
}

TEST(ValidFiles, EncloseWhatTheirClosedFormsSay) {
  for (const AcceptedCase& made : validCases()) {
    SCOPED_TRACE(made.file.id);
    // Much tighter than the tolerance for readers. A sum over many cells rounds once for each.
    const double cells = sumOf(made.file.describe->json, "cells");
    const double rounding = std::max(2e-13, cells * std::numeric_limits<double>::epsilon());
    const auto expectNear = [&](const Answer& answer, const char* member, double expected) {
      const double within = 1e-5 * sumOf(answer.within, member);
      EXPECT_NEAR(sumOf(answer.json, member), expected, rounding * std::abs(expected) + within);
    };
    if (made.hypervolume) expectNear(*made.file.describe, "hypervolume", *made.hypervolume);
    if (!made.sliceVolume) continue;
    for (const ExpectedSlice& slice : made.file.slices) {
      SCOPED_TRACE(slice.time);
      expectNear({slice.answer, slice.within}, "volume", made.sliceVolume(slice.time));
    }
  }
}

TEST(ValidFiles, AreClosedOrientedManifolds) {
  // Nothing is enclosed, or numbers are so far from 1 that a cell's volume is lost to rounding.
  const std::map<std::string, std::string> exceptions = {
      {"valid/caps-alone", "inside-out"},
      {"valid/body-without-vertices", "no-cells"},
      {"valid/float32-extremes", "degenerate-cell"},
      {"valid/means-are-summed-in-order", "degenerate-cell"},
      {"valid/neighbouring-times", "degenerate-cell"},
      {"valid/subnormal-numbers", "degenerate-cell"},
      {"valid/times-of-1e300", "degenerate-cell"},
  };
  for (const AcceptedCase& made : validCases()) {
    SCOPED_TRACE(made.file.id);
    const platform::TestFolder folder;
    const auto file = folder.write("file.t4d", made.file.bytes);
    const auto validation = tools::validate(file, {.vertexLinks = true});
    ASSERT_TRUE(validation);
    for (const measure::Issue& issue : validation->issues.issues) {
      const auto known = exceptions.find(made.file.id);
      if (known != exceptions.end() && known->second == issue.code) continue;
      ADD_FAILURE() << issue.code << ": " << issue.message;
    }
  }
}

}  // namespace
}  // namespace t4d::conformance
