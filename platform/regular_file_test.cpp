#include "platform/regular_file.h"

#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

class RegularFile : public testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_ / name; }
  std::string faultOf(const std::string& name) const {
    const auto size = sizeOfRegularFile(path(name));
    return size ? "" : size.error().message;
  }
  TestFolder folder_;
};

TEST_F(RegularFile, WhatMayNeverEndOrNeverBeginIsRefused) {
  std::ofstream(path("file")) << "12345";
  EXPECT_EQ(sizeOfRegularFile(path("file")), 5U);
  fs::create_symlink(path("file"), path("link"));
  EXPECT_EQ(sizeOfRegularFile(path("link")), 5U);
  EXPECT_EQ(faultOf("missing"), "no such file");
  EXPECT_EQ(faultOf("."), "is a folder; name a file in it");
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", path("link-to-pipe"));
  fs::create_symlink("/dev/zero", path("device"));
  for (const char* name : {"pipe", "link-to-pipe", "device"}) {
    EXPECT_EQ(faultOf(name), "is not a regular file") << name;
  }
  fs::create_symlink("loop", path("loop"));
  EXPECT_NE(faultOf("loop"), "");
}

TEST_F(RegularFile, LinksAreFollowedBeforeAFileIsWithinAFolder) {
  fs::create_directories(path("in/below"));
  std::ofstream(path("in/below/file")) << "x";
  std::ofstream(path("out")) << "x";
  std::ofstream(path("in2")) << "x";
  fs::create_symlink("below/file", path("in/link"));
  fs::create_symlink("../out", path("in/leads-out"));
  fs::create_directory_symlink("..", path("in/up"));
  fs::create_directory_symlink("in", path("other"));
  for (const char* name : {"in/below/file", "in/link", "in/up/in/link", "other/link"}) {
    EXPECT_TRUE(isWithinFolder(path(name), path("in"))) << name;
    EXPECT_TRUE(isWithinFolder(path(name), path("other"))) << name;
  }
  for (const char* name : {"in/leads-out", "in/up/out", "out", "in2", "in/missing"}) {
    EXPECT_FALSE(isWithinFolder(path(name), path("in"))) << name;
  }
}

}  // namespace
}  // namespace t4d::platform
