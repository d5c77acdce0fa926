#include "conformance/driver/damage.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/corpus.h"
#include "platform/test_folder.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<CorpusFile>& validFiles() {
  static const std::vector<CorpusFile> files = [] {
    std::vector<CorpusFile> all = makeCorpus();
    std::erase_if(all, [](const CorpusFile& file) { return file.validity != Validity::Valid; });
    return all;
  }();
  return files;
}

const CorpusFile& validFile(const std::string& id) {
  for (const CorpusFile& file : validFiles()) {
    if (file.id == id) return file;
  }
  throw std::invalid_argument(id);
}

/// Our reader on bytes, by way of a file.
class Damage : public testing::Test {
 protected:
  fs::path file(const std::string& bytes) const { return folder_.write("file.t4d", bytes); }
  platform::TestFolder folder_;
};

TEST_F(Damage, PartsAreAllOfAFile) {
  for (const CorpusFile& file : validFiles()) {
    SCOPED_TRACE(file.id);
    std::uint64_t at = 0;
    for (const Part& part : partsOf(file.bytes)) {
      ASSERT_EQ(part.offset, at) << part.name;
      ASSERT_GT(part.size, 0U) << part.name;
      at += part.size;
    }
    EXPECT_EQ(at, file.bytes.size());
  }
}

TEST_F(Damage, OneBitOfAPartIsFlipped) {
  const std::string& bytes = validFile("valid/one-simplex").bytes;
  for (const Part& part : partsOf(bytes)) {
    const Bit bit = bitOf(part);
    ASSERT_GE(bit.offset, part.offset);
    ASSERT_LT(bit.offset, part.offset + part.size);
    const std::string damaged = flipped(bytes, bit);
    ASSERT_EQ(damaged.size(), bytes.size());
    for (std::uint64_t at = 0; at < bytes.size(); ++at) {
      ASSERT_EQ(damaged[at] ^ bytes[at], at == bit.offset ? static_cast<char>(1 << bit.bit) : 0);
    }
  }
}

TEST_F(Damage, EveryFlippedBitAndEveryCutMakesAFileInvalid) {
  for (const CorpusFile& valid : validFiles()) {
    SCOPED_TRACE(valid.id);
    ASSERT_TRUE(describeFile(file(valid.bytes)));
    for (const Part& part : partsOf(valid.bytes)) {
      EXPECT_FALSE(describeFile(file(flipped(valid.bytes, bitOf(part))))) << part.name;
    }
    for (const std::uint64_t length : cutLengths(valid.bytes)) {
      EXPECT_FALSE(describeFile(file(valid.bytes.substr(0, length)))) << length;
    }
  }
}

TEST_F(Damage, FilesAreCutInEveryChunk) {
  for (const CorpusFile& valid : validFiles()) {
    const auto lengths = cutLengths(valid.bytes);
    EXPECT_TRUE(std::is_sorted(lengths.begin(), lengths.end()));
    EXPECT_EQ(lengths.front(), 0U);
    EXPECT_EQ(lengths.back(), valid.bytes.size() - 1);
    for (const Part& part : partsOf(valid.bytes)) {
      if (!part.name.starts_with("the payload of")) continue;
      EXPECT_TRUE(std::binary_search(lengths.begin(), lengths.end(), part.offset)) << part.name;
    }
  }
}

TEST_F(Damage, SomeAreAsManyAsAskedAndOthersForAnotherSeed) {
  EXPECT_THAT(someOf(4, 4, 1), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(someOf(0, 4, 1), IsEmpty());
  const auto some = someOf(1000, 10, 1);
  EXPECT_EQ(std::set(some.begin(), some.end()).size(), 10U);
  EXPECT_TRUE(std::is_sorted(some.begin(), some.end()));
  EXPECT_LT(some.back(), 1000U);
  EXPECT_EQ(some, someOf(1000, 10, 1));
  EXPECT_NE(some, someOf(1000, 10, 2));
}

TEST_F(Damage, AFileOfTwoSlabsKeepsTheOneThatASliceNeeds) {
  const std::string& bytes = validFile("valid/cross-polytope").bytes;
  const auto names = [&](double time) {
    std::set<std::string> types;
    const auto parts = partsForSlice(bytes, time);
    EXPECT_TRUE(parts);
    for (const Part& part : parts->unneeded) types.insert(part.name.substr(0, 4));
    return std::pair(parts->unneeded.size(), types);
  };
  // Both slabs share the layer; each has its own CONN. Outside their times, none is needed.
  const std::pair<std::size_t, std::set<std::string>> one = {2, {"CONN", "SLAB"}};
  const std::pair<std::size_t, std::set<std::string>> all = {5, {"CONN", "LAYR", "SLAB"}};
  for (const double time : {-1.0, -0.5, 0.0, 0.5, 1.0}) EXPECT_EQ(names(time), one) << time;
  for (const double time : {-2.0, 2.0}) EXPECT_EQ(names(time), all) << time;
  const auto first = [&](double time) {
    return partsForSlice(bytes, time)->unneeded.front().offset;
  };
  EXPECT_EQ(first(-0.5), first(-1));
  EXPECT_NE(first(-0.5), first(0));
}

TEST_F(Damage, ATimeIsThatOfASlabThatNeedsTheChunk) {
  const std::string& bytes = validFile("valid/cross-polytope").bytes;
  const std::uint64_t done = bytes.find("DONE\x01");
  const auto timeOfFirst = [&](const char* type) { return timeThatReads(bytes, bytes.find(type)); };
  const auto timeOfLast = [&](const char* type) {
    return timeThatReads(bytes, bytes.rfind(type, done));
  };
  EXPECT_EQ(timeOfFirst("CONN\x01"), -0.5);
  EXPECT_EQ(timeOfFirst("SLAB\x01"), -0.5);
  EXPECT_EQ(timeOfFirst("LAYR\x01"), -0.5);  // of both slabs
  EXPECT_EQ(timeOfLast("SLAB\x01"), 0.5);
  EXPECT_EQ(timeOfLast("CONN\x01"), 0.5);
  EXPECT_EQ(timeThatReads(bytes, done), -0.5);
  EXPECT_EQ(timeThatReads(bytes, bytes.size() - 1), -0.5);
  EXPECT_EQ(timeThatReads(bytes, 24), std::nullopt);  // HEAD, of which INDX has a copy
}

TEST_F(Damage, AFileWithoutIndexHasNoChunksThatASliceDoesNotNeed) {
  EXPECT_FALSE(partsForSlice(validFile("valid/no-index").bytes, 0.5));
  EXPECT_EQ(timeThatReads(validFile("valid/no-index").bytes, 24), std::nullopt);
}

TEST_F(Damage, SlicesDoNotMissWhatTheyDoNotNeed) {
  int tried = 0;
  for (const CorpusFile& valid : validFiles()) {
    for (const ExpectedSlice& slice : valid.slices) {
      const auto parts = partsForSlice(valid.bytes, slice.time);
      if (!parts || parts->unneeded.empty()) continue;
      ++tried;
      for (const Garbage garbage : {Garbage::Ones, Garbage::Noise}) {
        SCOPED_TRACE(valid.id + " at " + std::to_string(slice.time));
        const std::string bytes = overwritten(valid.bytes, parts->unneeded, garbage);
        EXPECT_EQ(bytes.size(), valid.bytes.size());
        const auto answer = sliceFile(file(bytes), slice.time);
        ASSERT_TRUE(answer) << answer.error().text();
        EXPECT_THAT(differences({slice.answer, slice.within}, answer->json), IsEmpty());
        EXPECT_FALSE(describeFile(file(bytes)));
      }
    }
  }
  EXPECT_GT(tried, 5);
}

TEST_F(Damage, SlicesMissWhatTheyRead) {
  for (const CorpusFile& valid : validFiles()) {
    const double time = valid.slices.front().time;
    const auto parts = partsForSlice(valid.bytes, time);
    if (!parts) continue;
    for (const Part& part : parts->read) {
      SCOPED_TRACE(valid.id + ", " + part.name);
      EXPECT_FALSE(sliceFile(file(flipped(valid.bytes, bitOf(part))), time));
    }
  }
}

}  // namespace
}  // namespace t4d::conformance
