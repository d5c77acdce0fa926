#include "t4d/formats/t4d/shared_join.h"

#include <gmock/gmock.h>

#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/test_slabs.h"

namespace t4d::formats {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// Consecutive parts of the slabs of some bodies.
std::vector<fs::path> partsOf(const std::vector<std::vector<model::Slab>>& bodies,
                              std::size_t count, const T4dWriteOptions& options = {}) {
  std::vector<fs::path> parts;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::vector<model::Slab>> own;
    for (const std::vector<model::Slab>& slabs : bodies) {
      const model::PartRange range = model::Part{i + 1, count}.of(slabs.size());
      const auto at = [&](std::uint64_t k) { return slabs.begin() + std::ptrdiff_t(k); };
      own.emplace_back(at(range.begin), at(range.end));
    }
    parts.push_back(writeT4d("part" + std::to_string(i) + ".t4d", own, options));
  }
  return parts;
}

fs::path folderOf(const fs::path& into) { return into.string() + ".joining"; }

fs::path freshPath(const std::string& name) {
  fs::path path = temporaryPath(name);
  fs::remove(path);
  fs::remove_all(folderOf(path));
  return path;
}

/// Copies share after share, the last first.
void copyAll(const fs::path& into, std::uint64_t shares) {
  for (std::uint64_t i = shares; i > 0; --i) {
    const auto copied = copyPlannedParts(into, {i, shares});
    ASSERT_TRUE(copied) << copied.error().text();
  }
}

std::string errorOf(const auto& result) { return result ? "" : result.error().text(); }

TEST(SharedJoin, MakesTheBytesOfAJoin) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::vector<std::vector<model::Slab>> bodies;
    for (unsigned body = 0; body <= seed % 3; ++body) {
      bodies.push_back(RandomSlabs(10 * seed + body).make(40));
    }
    const T4dWriteOptions options = {.compression = seed % 2 == 0 ? 3 : 0,
                                     .spareEvery = seed % 5 == 0 ? 2U : 0U};
    for (const std::size_t count : {1, 2, 7, 40}) {
      const std::vector<fs::path> parts = partsOf(bodies, count, options);
      const fs::path joined = temporaryPath("joined.t4d");
      ASSERT_TRUE(joinT4d(parts, joined));
      const fs::path shared = freshPath("shared.t4d");
      const auto planned = planJoin(parts, shared);
      ASSERT_TRUE(planned) << planned.error().text();
      EXPECT_FALSE(fs::exists(shared));
      EXPECT_EQ(*plannedParts(shared), count);
      copyAll(shared, std::min<std::size_t>(count, 3));
      const auto finished = finishJoin(shared);
      ASSERT_TRUE(finished) << finished.error().text();
      EXPECT_TRUE(system::contents(shared) == system::contents(joined)) << seed << ", in " << count;
      EXPECT_EQ(finished->bytes, fs::file_size(shared));
      EXPECT_EQ(finished->bodies.size(), bodies.size());
      EXPECT_FALSE(fs::exists(folderOf(shared)));
    }
  }
}

class PlannedJoin : public testing::Test {
 protected:
  void SetUp() override {
    parts_ = partsOf({RandomSlabs(3).make(12)}, 3);
    into_ = freshPath("planned.t4d");
    const auto planned = planJoin(parts_, into_);
    ASSERT_TRUE(planned) << planned.error().text();
  }

  std::vector<fs::path> parts_;
  fs::path into_;
};

TEST_F(PlannedJoin, IsNotFinishedBeforeAllPartsAreCopied) {
  ASSERT_TRUE(copyPlannedParts(into_, {2, 3}));
  EXPECT_THAT(errorOf(finishJoin(into_)),
              HasSubstr("2 of 3 files are not copied yet: part0.t4d, part2.t4d"));
  EXPECT_FALSE(fs::exists(into_));
  copyAll(into_, 3);
  EXPECT_TRUE(finishJoin(into_));
}

TEST_F(PlannedJoin, CopiesNoPartTwice) {
  EXPECT_EQ(copyPlannedParts(into_, {1, 1})->parts, 3);
  EXPECT_EQ(copyPlannedParts(into_, {1, 2})->parts, 0);
}

TEST_F(PlannedJoin, IsPlannedOnce) {
  EXPECT_THAT(errorOf(planJoin(parts_, into_)), HasSubstr("is planned already"));
}

TEST_F(PlannedJoin, IsNotFinishedWhileAPartIsCopied) {
  copyAll(into_, 3);
  const fs::path mesh = folderOf(into_) / "mesh.t4d";
  {
    const auto late = OutputFile::openToRewrite(mesh, OutputFile::Sharing::Shared);
    ASSERT_TRUE(late);
    EXPECT_THAT(errorOf(finishJoin(into_)), HasSubstr("another process writes to it"));
  }
  EXPECT_FALSE(fs::exists(into_));
  EXPECT_TRUE(finishJoin(into_));
}

/// As after a crash between its last two steps.
TEST_F(PlannedJoin, CanBeFinishedTwice) {
  copyAll(into_, 3);
  const fs::path kept = temporaryPath("kept");
  fs::remove_all(kept);
  fs::copy(folderOf(into_), kept);
  const auto first = finishJoin(into_);
  ASSERT_TRUE(first);
  fs::remove(kept / "mesh.t4d");
  fs::rename(kept, folderOf(into_));
  const auto again = finishJoin(into_);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->bytes, first->bytes);
  EXPECT_FALSE(fs::exists(folderOf(into_)));
  fs::create_directory(folderOf(into_));  // or between its last three
  EXPECT_TRUE(planJoin(parts_, into_));
}

/// Machines may know the folder by other names.
TEST_F(PlannedJoin, CanMoveWithItsParts) {
  const fs::path elsewhere = temporaryPath("elsewhere");
  fs::remove_all(elsewhere);
  fs::create_directory(elsewhere);
  for (const fs::path& part : parts_) fs::rename(part, elsewhere / part.filename());
  fs::rename(folderOf(into_), elsewhere / folderOf(into_).filename());
  copyAll(elsewhere / into_.filename(), 3);
  EXPECT_TRUE(finishJoin(elsewhere / into_.filename()));
}

TEST_F(PlannedJoin, RefusesAnotherPart) {
  fs::copy_file(parts_[0], parts_[1], fs::copy_options::overwrite_existing);
  EXPECT_THAT(errorOf(copyPlannedParts(into_, {2, 3})),
              HasSubstr("is not the file that was planned"));
  fs::remove(parts_[2]);
  EXPECT_THAT(errorOf(copyPlannedParts(into_, {3, 3})), HasSubstr("part2.t4d"));
}

TEST_F(PlannedJoin, FindsAnyDamageOfAPart) {
  const std::string sound = system::contents(parts_[1]);
  const std::vector<ChunkHeader> chunks = listChunks(sound);
  std::size_t found = 0;
  for (std::size_t at = chunks[1].offset; at < sound.size(); at += 61) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    writeFile(parts_[1], damaged);
    const auto copied = copyPlannedParts(into_, {2, 3});
    if (!copied) {
      ++found;
      EXPECT_THAT(copied.error().text(), HasSubstr("part1.t4d"));
      continue;
    }
    // What is not copied is made anew: the layer of the seam, fronts of slabs, what follows them.
    fs::remove(folderOf(into_) / "copied-2");
  }
  EXPECT_GT(found, 0U);
  writeFile(parts_[1], sound);
  copyAll(into_, 3);
  ASSERT_TRUE(finishJoin(into_));
  EXPECT_TRUE(checkT4dFile(into_));
}

TEST_F(PlannedJoin, RefusesADamagedPlan) {
  const fs::path plan = folderOf(into_) / "plan.json";
  const std::string sound = system::contents(plan);
  for (std::size_t at = 0; at < sound.size(); ++at) {
    for (const char other : {'9', '-', '"', ' '}) {
      std::string damaged = sound;
      damaged[at] = other;
      writeFile(plan, damaged);
      const auto copied = copyPlannedParts(into_, {1, 3});  // neither crashes nor hangs
      if (copied) fs::remove(folderOf(into_) / "copied-1");
    }
  }
  const fs::path runs = folderOf(into_) / "runs";
  writeFile(plan, sound);
  const std::string soundRuns = system::contents(runs);
  for (std::size_t at = 0; at < soundRuns.size(); ++at) {
    std::string damaged = soundRuns;
    damaged[at] = static_cast<char>(damaged[at] ^ 8);
    writeFile(runs, damaged);
    EXPECT_THAT(errorOf(copyPlannedParts(into_, {1, 1})), HasSubstr("is not what the plan says"));
    for (const char* mark : {"copied-1", "copied-2", "copied-3"}) {
      fs::remove(folderOf(into_) / mark);
    }
  }
  writeFile(runs, "");
  EXPECT_THAT(errorOf(copyPlannedParts(into_, {1, 3})), HasSubstr("is not what the plan says"));
}

TEST(SharedJoin, FollowsALink) {
  const fs::path target = freshPath("target.t4d");
  const fs::path link = freshPath("link.t4d");
  fs::create_symlink(target, link);
  ASSERT_TRUE(planJoin(partsOf({RandomSlabs(1).make(3)}, 2), link));
  copyAll(link, 2);
  ASSERT_TRUE(finishJoin(link));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_TRUE(fs::is_regular_file(target));
}

TEST(SharedJoin, NeedsAPlanAndARegularFile) {
  const fs::path into = freshPath("none.t4d");
  EXPECT_THAT(errorOf(copyPlannedParts(into, {1, 1})),
              HasSubstr("no join into this file is planned"));
  EXPECT_THAT(errorOf(finishJoin(into)), HasSubstr("no join into this file is planned"));
  const std::vector<fs::path> parts = partsOf({RandomSlabs(1).make(3)}, 2);
  EXPECT_THAT(errorOf(planJoin(parts, "/dev/null")), HasSubstr("is not a regular file"));
  EXPECT_THAT(errorOf(planJoin(parts, "/")), HasSubstr("is a folder"));
  EXPECT_THAT(errorOf(planJoin(parts, "no/such.t4d")), HasSubstr("there is no folder no"));
  const auto unindexed = partsOf({RandomSlabs(1).make(3)}, 1, {.index = false});
  EXPECT_THAT(errorOf(planJoin(unindexed, into)), HasSubstr("has no index"));
  EXPECT_THAT(errorOf(planJoin({parts[1], parts[0]}, into)), HasSubstr("cannot be joined after"));
  EXPECT_FALSE(fs::exists(folderOf(into)));
}

}  // namespace
}  // namespace t4d::formats
