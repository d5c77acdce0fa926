#include "platform/open_file.h"

#include <array>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

std::string text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(OpenFile, ReadsAtOffsetsUpToTheEnd) {
  const TestFolder folder;
  auto file = OpenFile::openRegular(folder.write("a", "0123456789"));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size(), 10U);
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(file->readAt(2, bytes).value(), 4U);
  EXPECT_EQ(text(bytes), "2345");
  EXPECT_EQ(file->readAt(8, bytes).value(), 2U);
  EXPECT_EQ(text(bytes), "8945");
  EXPECT_EQ(file->readAt(10, bytes).value(), 0U);
  file->seek(7);
  EXPECT_EQ(file->read(bytes).value(), 3U);
  EXPECT_EQ(file->read(bytes).value(), 0U);
}

TEST(OpenFile, SaysWhyNot) {
  const TestFolder folder;
  EXPECT_EQ(OpenFile::open(folder.path()).error().message, "is a folder");
  EXPECT_EQ(OpenFile::openRegular(folder / "no").error().text(),
            (folder / "no").string() + ": cannot open: No such file or directory");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  // Nobody writes to it.
  EXPECT_EQ(OpenFile::openRegular(folder / "pipe", "is a pipe").error().message, "is a pipe");
}

TEST(OpenFile, WaitsForWhatComesThroughAPipe) {
  const TestFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::jthread writer([&] { std::ofstream(pipe) << "ab"; });
  auto file = OpenFile::open(pipe);
  ASSERT_TRUE(file);
  std::array<std::byte, 2> bytes{};
  EXPECT_EQ(file->read(bytes).value(), 2U);
  EXPECT_EQ(text(bytes), "ab");
  EXPECT_EQ(file->read(bytes).value(), 0U);
}

TEST(OpenFile, VersionsDiffer) {
  const TestFolder folder;
  const auto before = OpenFile::openRegular(folder.write("a", "1"));
  const auto same = OpenFile::openRegular(folder / "a");
  const auto after = OpenFile::openRegular(folder.write("a", "12"));
  EXPECT_EQ(before->version(), same->version());
  EXPECT_NE(before->version(), after->version());
}

}  // namespace
}  // namespace t4d::platform
