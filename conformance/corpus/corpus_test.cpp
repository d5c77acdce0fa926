#include "conformance/corpus/corpus.h"

#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/zstd_frame.h"
#include "platform/test_folder.h"
#include "tests/paths.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;

constexpr unsigned kZstdOfTheCorpus = 10504;  // 1.5.4, of Debian 12

TEST(Corpus, IsKeptAsItIsMade) {
  if (zstdLibraryVersion() != kZstdOfTheCorpus) {
    GTEST_SKIP() << "another zstd library makes other frames, just as good";
  }
  const auto differences = verifyCorpus(T4D_CORPUS);
  ASSERT_TRUE(differences) << differences.error().text();
  EXPECT_THAT(*differences, testing::IsEmpty())
      << "t4d-corpus generate conformance/corpus/files writes them";
}

TEST(Corpus, IsTheSameEveryTime) {
  const std::vector<CorpusFile> once = makeCorpus();
  const std::vector<CorpusFile> again = makeCorpus();
  ASSERT_EQ(once.size(), again.size());
  EXPECT_EQ(manifestText(once), manifestText(again));
  std::set<std::string> ids;
  for (const CorpusFile& file : once) EXPECT_TRUE(ids.insert(file.id).second) << file.id;
}

TEST(Corpus, IsWrittenWholeAndDifferencesAreNamed) {
  const platform::TestFolder folder;
  const auto directory = folder / "corpus";
  ASSERT_TRUE(writeCorpus(directory));
  EXPECT_THAT(*verifyCorpus(directory), testing::IsEmpty());
  for (const auto& entry : json::parse(std::ifstream(directory / "manifest.json"))["files"]) {
    const auto path = directory / entry["file"].get<std::string>();
    EXPECT_EQ(std::filesystem::file_size(path), entry["bytes"]) << path;
  }
  std::filesystem::remove(directory / "valid/one-simplex.t4d");
  std::ofstream(directory / "valid/one-simplex.json", std::ios::app) << "\n";
  std::ofstream(directory / "invalid/H1-other.t4d") << "other";
  EXPECT_THAT(
      *verifyCorpus(directory),
      testing::UnorderedElementsAre("valid/one-simplex.t4d is missing",
                                    testing::StartsWith("valid/one-simplex.json is different"),
                                    "invalid/H1-other.t4d is not a file of the corpus"));
}

}  // namespace
}  // namespace t4d::conformance
