#pragma once

#include <filesystem>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "t4d/conformance/answers.h"
#include "t4d/conformance/corpus/corpus.h"

namespace t4d::conformance {

/// Expects our own reader's answers to `file`, stored at `path`, to be the corpus's: `description`
/// and the slices.
inline void expectAnswers(const CorpusFile& file, const std::filesystem::path& path,
                          const Answer& description) {
  using nlohmann::json;
  const auto expectAnswer = [](const std::string& expected, const std::string& within,
                               const std::string& given) {
    EXPECT_THAT(differences(json::parse(expected), json::parse(within), json::parse(given)),
                testing::IsEmpty());
  };
  expectAnswer(file.describe->json, file.describe->within, description.json);
  for (const ExpectedSlice& expected : file.slices) {
    const auto slice = sliceFile(path, expected.time);
    ASSERT_TRUE(slice) << slice.error().text();
    expectAnswer(expected.answer, expected.within, slice->json);
  }
}

}  // namespace t4d::conformance
