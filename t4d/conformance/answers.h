#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "t4d/formats/t4d/reader.h"

/// What a reader under test says of a file, and how near that has to be (t4d/formats/t4d/SPEC.md,
/// appendix "a reader under test").
namespace t4d::conformance {

/// A JSON object as the appendix has it.
struct Answer {
  std::string json;
  /// An array with an object for each body: how far from `json` a right answer may be, for what
  /// rounding can move: "hypervolume" of `describe`; "volume", "area" and "length" (of bounds) of
  /// `slice`.
  std::string within;
};

/// A body and its name, wherever its slabs come from.
struct NamedSource {
  std::string name;
  const model::Source* source = nullptr;
};

/// The answers for slabs at hand: what a file of them must lead to.
Result<Answer> describe(const std::vector<NamedSource>& bodies, formats::T4dVersion version,
                        const std::vector<std::string>& features);
Result<Answer> sliceAt(const std::vector<NamedSource>& bodies, double time);

/// The answers of our reader. `describeFile` reads everything, `sliceFile` what the slice needs.
Result<Answer> describeFile(const std::filesystem::path& path);
Result<Answer> sliceFile(const std::filesystem::path& path, double time);

/// "0x1.8p+1": the same double again through strtod.
std::string hexFloat(double number);

/// What is different between an answer and what was expected, a sentence each with the path of the
/// member ("bodies[0].slabs[2].end"); empty where the answer is right. `within` as in Answer.
std::vector<std::string> differences(const nlohmann::ordered_json& expected,
                                     const nlohmann::ordered_json& within,
                                     const nlohmann::ordered_json& actual);

}  // namespace t4d::conformance
