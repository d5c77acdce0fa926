#include "formats/output_file.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "platform/test_folder.h"

namespace t4d::formats {
namespace {

TEST(OutputFile, AppearsWholeOnCommit) {
  const platform::TestFolder folder;
  auto file = OutputFile::create(folder / "out");
  ASSERT_TRUE(file) << file.error().text();
  const std::string large(3'000'000, 'x');
  ASSERT_TRUE(file->write(large.data(), large.size()));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(platform::contents(folder / "out"), large);
  EXPECT_EQ(folder.names().size(), 1U);
}

TEST(OutputFile, LeavesTheOldFileAndNothingElseWithoutCommit) {
  const platform::TestFolder folder;
  folder.write("out", "old");
  {
    auto file = OutputFile::create(folder / "out");
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write("new", 3));
  }
  EXPECT_EQ(platform::contents(folder / "out"), "old");
  EXPECT_EQ(folder.names().size(), 1U);
}

TEST(OutputFile, WritesThroughASymbolicLink) {
  const platform::TestFolder folder;
  folder.write("real", "old");
  std::filesystem::create_symlink(folder / "real", folder / "link");
  auto file = OutputFile::create(folder / "link");
  ASSERT_TRUE(file && file->write("new", 3) && file->commit());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(platform::contents(folder / "real"), "new");
}

TEST(OutputFile, CommitsAllOrNone) {
  const platform::TestFolder folder;
  const auto writeTwo = [&] {
    std::vector<OutputFile> files;
    for (const char* name : {"a", "b"}) {
      auto file = OutputFile::create(folder / name);
      EXPECT_TRUE(file && file->write(name, 1));
      if (file) files.push_back(std::move(*file));
    }
    return files;
  };
  {
    auto files = writeTwo();
    std::filesystem::create_directory(folder / "b");  // in the way
    EXPECT_FALSE(OutputFile::commitAll(files));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
  std::filesystem::remove(folder / "b");
  auto files = writeTwo();
  ASSERT_TRUE(OutputFile::commitAll(files));
  EXPECT_EQ(platform::contents(folder / "a"), "a");
  EXPECT_EQ(platform::contents(folder / "b"), "b");
}

TEST(OutputFile, SaysThatTheDiskIsFull) {
  auto file = OutputFile::create("/dev/full");
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write("x", 1));
  const auto done = file->commit();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::Failed);
  EXPECT_EQ(done.error().text(), "/dev/full: cannot write: No space left on device");
}

TEST(OutputFile, RefusesAFolderAndAMissingFolder) {
  const platform::TestFolder folder;
  EXPECT_FALSE(OutputFile::create(folder.path()));
  const auto missing = OutputFile::create(folder / "no" / "out");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("there is no folder"), std::string::npos);
}

}  // namespace
}  // namespace t4d::formats
