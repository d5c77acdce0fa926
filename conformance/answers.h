#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/slice.h"

/// The answer a reader under test must give for a file, with tolerances (formats/t4d/SPEC.md,
/// appendix "a reader under test").
namespace t4d::conformance {

/// A JSON object as defined in the appendix.
struct Answer {
  std::string json;
  /// An array with one object per body: tolerances for those members of `json` that rounding
  /// affects. These are "hypervolume" for `describe`, and "volume", "area" and "length" (of bounds)
  /// for `slice`.
  std::string within;
};

/// A body and its name, whatever the source of its slabs.
struct NamedSource {
  std::string name;
  const model::Source* source = nullptr;
};

/// The required answers for a file with the given slabs.
Result<Answer> describe(const std::vector<NamedSource>& bodies, formats::T4dVersion version,
                        const std::vector<std::string>& features);
Result<Answer> sliceAt(const std::vector<NamedSource>& bodies, double time);
/// The answer for a slice by a hyperplane that is not of constant time. If the hyperplane is not of
/// constant x, y or z, the reader chooses the axes, so the answer has no bounds.
Result<Answer> sliceBy(const std::vector<NamedSource>& bodies, const slice::Hyperplane& hyperplane);

/// The answers of our own reader. `describeFile` reads the whole file, the others only what the
/// slice needs.
Result<Answer> describeFile(const std::filesystem::path& path);
Result<Answer> sliceFile(const std::filesystem::path& path, double time);
Result<Answer> sliceFile(const std::filesystem::path& path, const slice::Hyperplane& hyperplane);

/// A double as text, such as "0x1.8p+1", that strtod reads back as the same double.
std::string hexFloat(double number);

/// The differences between an answer, which is JSON, and the expected one, one sentence each, with
/// the path of the member ("bodies[0].slabs[2].end"); empty if the answer is right.
std::vector<std::string> differences(const Answer& expected, const std::string& actual);

}  // namespace t4d::conformance
