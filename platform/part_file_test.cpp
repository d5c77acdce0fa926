#include "platform/part_file.h"

#include <array>
#include <csignal>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "platform/kept_inputs.h"
#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

class PartFiles : public testing::Test {
 protected:
  PartFile write(const std::string& name, const std::string& text) const {
    auto part = PartFile::create(folder_ / name);
    EXPECT_TRUE(part && part->write(text)) << part.error().text();
    return std::move(*part);
  }
  std::size_t files() const { return folder_.names().size(); }

  TestFolder folder_;
};

TEST_F(PartFiles, NeverTakeThePlaceOfAFolderADeviceOrALink) {
  fs::create_directory(folder_ / "folder");
  EXPECT_FALSE(PartFile::create(folder_ / "folder"));
  fs::create_symlink("/dev/full", folder_ / "full");
  auto full = PartFile::create(folder_ / "full");
  ASSERT_TRUE(full);
  const auto written = full->write("text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message, "cannot write: No space left on device");
  fs::create_symlink("real", folder_ / "link");
  PartFile part = write("link", "text");
  ASSERT_TRUE(PartFile::putInPlace({&part, 1}));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(contents(folder_ / "real"), "text");
  EXPECT_EQ(files(), 4);
}

TEST_F(PartFiles, GetTheirNamesTogether) {
  std::array parts = {write("a", "one"), write("b", "two")};
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  ASSERT_TRUE(PartFile::putInPlace(parts));
  EXPECT_EQ(contents(folder_ / "a"), "one");
  EXPECT_EQ(contents(folder_ / "b"), "two");
  EXPECT_EQ(files(), 2);
}

TEST_F(PartFiles, AreRemovedAtTheEndOfTheirLife) {
  {
    PartFile part = write("a", "one");
    const PartFile moved = std::move(part);
    EXPECT_EQ(files(), 1);
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(PartFiles, StayWhereTheyCannotBePut) {
  {
    PartFile part = write("taken", "one");
    fs::create_directories(folder_ / "taken" / "by something");
    const auto put = PartFile::putInPlace({&part, 1});
    ASSERT_FALSE(put);
    EXPECT_EQ(put.error().code, ErrorCode::Failed);
    EXPECT_EQ(put.error().where.text(), (folder_ / "taken").string());
    EXPECT_EQ(files(), 2);
  }
  EXPECT_EQ(files(), 1);
}

TEST_F(PartFiles, OfWhichOneCannotBePutReplaceNoOldFile) {
  folder_.write("a", "old a");
  {
    std::array parts = {write("a", "new a"), write("b", "new b"), write("c", "new c")};
    fs::create_directories(folder_ / "c" / "in the way");
    EXPECT_FALSE(PartFile::putInPlace(parts));
    EXPECT_EQ(contents(folder_ / "a"), "old a");
    EXPECT_FALSE(fs::exists(folder_ / "b"));
    fs::remove_all(folder_ / "c");
    ASSERT_TRUE(PartFile::putInPlace(parts));
  }
  EXPECT_EQ(contents(folder_ / "a") + contents(folder_ / "b") + contents(folder_ / "c"),
            "new anew bnew c");
  EXPECT_EQ(files(), 3);
}

TEST_F(PartFiles, OfOneTargetAreDifferentFiles) {
  PartFile one = write("a", "one");
  const PartFile two = write("a", "two");
  EXPECT_EQ(files(), 2);
  ASSERT_TRUE(PartFile::putInPlace({&one, 1}));
  EXPECT_EQ(contents(folder_ / "a"), "one");
  EXPECT_EQ(files(), 2);
}

TEST_F(PartFiles, OfKilledProcessesAreRemovedByTheNextOne) {
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::array parts = {PartFile::create(folder_ / "a"), PartFile::create(folder_ / "a"),
                              PartFile::create(folder_ / "b")};
    ::_exit(::write(ready[1], "x", 1) == 1 && ::pause());
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  const PartFile beside = write("a", "while the other lives");
  EXPECT_EQ(files(), 4);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(files(), 4);
  PartFile next = write("a", "text");
  EXPECT_EQ(files(), 3);  // also those of b, whose turn has not come
  ASSERT_TRUE(PartFile::putInPlace({&next, 1}));
  EXPECT_EQ(contents(folder_ / "a"), "text");
}

TEST_F(PartFiles, AreNotRemovedWhileTheyAreRead) {
  folder_.write(".a.1.part", "left behind");
  const KeptInputs kept;
  noteInput(folder_ / ".a.1.part");
  const PartFile part = write("a", "recovered");
  EXPECT_EQ(contents(folder_ / ".a.1.part"), "left behind");
}

TEST_F(PartFiles, MayHaveTheLongestName) {
  PartFile part = write(std::string(255, 'n'), "one");
  EXPECT_TRUE(PartFile::putInPlace({&part, 1}));
  const auto tooLong = PartFile::create(folder_ / std::string(256, 'n'));
  ASSERT_FALSE(tooLong);
  EXPECT_EQ(tooLong.error().message, "cannot open for writing: File name too long");
}

TEST_F(PartFiles, RemovedAllAtOnceLeaveWhatHasItsName) {
  PartFile done = write("done", "whole");
  ASSERT_TRUE(PartFile::putInPlace({&done, 1}));
  PartFile a = write("a", "half");
  const PartFile b = write("b with a much longer name than the other", "half");
  cleanUp();
  EXPECT_EQ(files(), 1);
  EXPECT_FALSE(PartFile::putInPlace({&a, 1}));
  // Later ones are files like any.
  PartFile later = write("later", "whole");
  ASSERT_TRUE(PartFile::putInPlace({&later, 1}));
  cleanUp();
  EXPECT_EQ(contents(folder_ / "done"), "whole");
  EXPECT_EQ(contents(folder_ / "later"), "whole");
}

TEST_F(PartFiles, OfManyThreadsAreAllRemoved) {
  std::vector<std::vector<PartFile>> kept(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    threads.emplace_back([&, i] {
      for (int k = 0; k < 200; ++k) {
        PartFile part = write(std::to_string(i) + "-" + std::to_string(k), "half");
        if (k % 3 == 0) kept[i].push_back(std::move(part));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(files(), 4 * 67);
  cleanUp();
  EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace t4d::platform
