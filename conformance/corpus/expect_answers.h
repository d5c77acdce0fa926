#pragma once

#include <filesystem>

#include <gmock/gmock.h>

#include "conformance/answers.h"
#include "conformance/corpus/corpus.h"

namespace t4d::conformance {

/// Expects our own reader's answers to `file`, stored at `path`, to be the corpus's: `description`
/// and the slices.
inline void expectAnswers(const CorpusFile& file, const std::filesystem::path& path,
                          const Answer& description) {
  EXPECT_THAT(differences(*file.describe, description.json), testing::IsEmpty());
  for (const ExpectedSlice& expected : file.slices) {
    const auto slice = sliceFile(path, expected.time);
    ASSERT_TRUE(slice) << slice.error().text();
    EXPECT_THAT(differences({expected.answer, expected.within}, slice->json), testing::IsEmpty());
  }
  for (const ExpectedSection& expected : file.sections) {
    const auto slice = sliceFile(path, expected.hyperplane);
    ASSERT_TRUE(slice) << slice.error().text();
    EXPECT_THAT(differences({expected.answer, expected.within}, slice->json), testing::IsEmpty());
  }
}

}  // namespace t4d::conformance
