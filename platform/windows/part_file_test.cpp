#include "platform/part_file.h"

#include <span>

#include <gtest/gtest.h>

#include "platform/kept_inputs.h"
#include "platform/open_file.h"
#include "platform/regular_file.h"
#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

class WindowsFiles : public testing::Test {
 protected:
  Result<void> write(const std::string& name, const std::string& text) const {
    auto part = PartFile::create(folder_ / name);
    if (!part) return part.error();
    if (auto written = part->write(text); !written) return written;
    return PartFile::putInPlace(std::span(&*part, 1));
  }

  TestFolder folder_;
};

TEST_F(WindowsFiles, AppearWholeAndReplaceTheOldOne) {
  folder_.write("a", "old");
  auto part = PartFile::create(folder_ / "a");
  ASSERT_TRUE(part && part->write("a\r\nb\n") && part->rewrite(0, "c"));
  ASSERT_TRUE(part->write("\x1a"));
  EXPECT_EQ(contents(folder_ / "a"), "old");
  EXPECT_EQ(folder_.names().size(), 2u);
  ASSERT_TRUE(PartFile::putInPlace(std::span(&*part, 1)));
  EXPECT_EQ(contents(folder_ / "a"), "c\r\nb\n\x1a");
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"a"});
}

// Elsewhere they are: the reader keeps the old one.
TEST_F(WindowsFiles, AreNotReplacedWhileTheyAreRead) {
  folder_.write("a", "old");
  const auto open = OpenFile::open(folder_ / "a");
  ASSERT_TRUE(open);
  const auto written = write("a", "new");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message, "cannot put in place: Permission denied");
  EXPECT_EQ(contents(folder_ / "a"), "old");
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"a"});
}

TEST_F(WindowsFiles, PartsThatNobodyWritesAreRemovedWithTheNextFile) {
  folder_.write(".a.1.part", "left");
  auto first = PartFile::create(folder_ / "a");
  auto second = PartFile::create(folder_ / "a");
  ASSERT_TRUE(first && second && first->write("1") && second->write("2"));
  EXPECT_EQ(folder_.names(), (std::vector<std::string>{".a.1.part", ".a.2.part"}));
  first->remove();
  ASSERT_TRUE(PartFile::putInPlace(std::span(&*second, 1)));
  EXPECT_EQ(contents(folder_ / "a"), "2");
}

TEST_F(WindowsFiles, OfThisRunAreNotReplaced) {
  folder_.write("a", "text");
  std::filesystem::create_hard_link(folder_ / "a", folder_ / "hard");
  const KeptInputs run;
  ASSERT_TRUE(sizeOfRegularFile(folder_ / "a"));
  EXPECT_FALSE(write("hard", "other"));
  EXPECT_EQ(contents(folder_ / "a"), "text");
}

TEST_F(WindowsFiles, ErrorsSayWhy) {
  EXPECT_EQ(write("none/a", "").error().message,
            "cannot open for writing: there is no folder " + (folder_ / "none").string());
  std::filesystem::create_directory(folder_ / "in");
  EXPECT_EQ(write("in", "").error().message, "is a folder; name a file in it");
  EXPECT_EQ(OpenFile::open(folder_ / "in").error().message, "is a folder");
  EXPECT_EQ(OpenFile::open(folder_ / "no").error().message,
            "cannot open: No such file or directory");
}

}  // namespace
}  // namespace t4d::platform
