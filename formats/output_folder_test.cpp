#include "formats/output_folder.h"

#include <gtest/gtest.h>

#include "formats/test_files.h"
#include "platform/test_folder.h"

namespace t4d::formats {
namespace {

namespace fs = std::filesystem;

class OutputFolder : public testing::Test {
 protected:
  platform::TestFolder place_;
  fs::path folder_ = place_ / "out";
};

TEST_F(OutputFolder, GetsFilesInNewFolders) {
  ASSERT_TRUE(writeInFolder(folder_, "a/b/c.txt", "one"));
  ASSERT_TRUE(writeInFolder(folder_, "a/b/c.txt", "two"));
  EXPECT_EQ(platform::contents(folder_ / "a/b/c.txt"), "two");
}

TEST_F(OutputFolder, IsNeverLeftThroughALink) {
  const fs::path outside = place_ / "outside";
  ASSERT_TRUE(writeInFolder(outside, "c.txt", "mine"));
  fs::create_directories(folder_);
  fs::create_symlink(outside / "c.txt", folder_ / "c.txt");
  fs::create_directory_symlink(outside, folder_ / "linked");
  fs::create_symlink(outside / "new.txt", folder_ / "new.txt");
  for (const char* name : {"c.txt", "linked/c.txt", "linked/new.txt", "new.txt"}) {
    EXPECT_FALSE(writeInFolder(folder_, name, "changed")) << name;
  }
  EXPECT_EQ(platform::contents(outside / "c.txt"), "mine");
  EXPECT_FALSE(fs::exists(outside / "new.txt"));
  // The folder that was named may be a link itself.
  fs::create_directory_symlink(outside, place_ / "named");
  EXPECT_TRUE(writeInFolder(place_ / "named", "c.txt", "changed"));
}

TEST_F(OutputFolder, OfKeptFilesIsNewOrEmptyOrOneOfBefore) {
  ASSERT_TRUE(makeKeptFolder(folder_));
  ASSERT_TRUE(writeInFolder(folder_, "kept.t4d", "bytes"));
  EXPECT_TRUE(makeKeptFolder(folder_));
  const fs::path other = place_ / "other";
  fs::create_directories(other);
  EXPECT_TRUE(makeKeptFolder(other));
  const fs::path foreign = place_ / "foreign";
  ASSERT_TRUE(writeInFolder(foreign, "mine.txt", "mine"));
  const auto refused = makeKeptFolder(foreign);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("foreign: the folder has other files"), std::string::npos);
  // A link is no mark.
  fs::create_symlink("mine.txt", foreign / ".t4d-kept");
  EXPECT_FALSE(makeKeptFolder(foreign));
  EXPECT_EQ(platform::contents(foreign / "mine.txt"), "mine");
}

}  // namespace
}  // namespace t4d::formats
