#include "platform/replaceable.h"

#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

class Replaceable : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& bytes) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  std::string refusalOf(const std::string& name) const {
    const auto checked = checkReplaceable(folder_, {&name, 1});
    return checked ? "" : checked.error().text();
  }

  TestFolder place_;
  fs::path folder_ = place_ / "out";
};

TEST_F(Replaceable, AFileThatIsNotThereIs) {
  EXPECT_EQ(refusalOf("frame_0000.ply"), "");
  fs::create_directories(folder_);
  EXPECT_EQ(refusalOf("frame_0000.ply"), "");
}

TEST_F(Replaceable, OnlyFilesWithTheMarkAre) {
  put("own.obj", "# written by t4d\nv 0 0 0\n");
  put("foreign.obj", "# written by hand\nv 0 0 0\n");
  put("empty.obj", "");
  EXPECT_EQ(refusalOf("own.obj"), "");
  EXPECT_NE(refusalOf("foreign.obj").find("foreign.obj: exists and was not written by t4d"),
            std::string::npos);
  EXPECT_NE(refusalOf("empty.obj"), "");
}

TEST_F(Replaceable, TheMarkOfGltfIsFoundAnywhere) {
  // The mark may also cross the border of two pieces that are read.
  for (const std::size_t before : {0U, 1000U, 65'530U, 200'000U}) {
    put("a.glb", std::string(before, 'x') + R"("generator":"t4d","version":"2.0")");
    EXPECT_EQ(refusalOf("a.glb"), "") << before;
  }
  put("a.ply", std::string(200'000, 'x') + "written by t4d");
  EXPECT_NE(refusalOf("a.ply"), "");
}

TEST_F(Replaceable, LinksNeverAre) {
  put("own.obj", "# written by t4d\n");
  put("elsewhere/own.obj", "# written by t4d\n");
  fs::create_symlink("own.obj", folder_ / "link.obj");
  fs::create_symlink("nowhere", folder_ / "dangling.obj");
  fs::create_directory_symlink("elsewhere", folder_ / "linked");
  EXPECT_EQ(refusalOf("elsewhere/own.obj"), "");
  for (const char* name : {"link.obj", "dangling.obj", "linked/own.obj", "linked/new.obj"}) {
    EXPECT_NE(refusalOf(name).find("is a symbolic link"), std::string::npos) << name;
  }
}

TEST_F(Replaceable, PipesAndFoldersAreNot) {
  fs::create_directories(folder_ / "folder.obj");
  ASSERT_EQ(::mkfifo((folder_ / "pipe.obj").c_str(), 0600), 0);
  for (const char* name : {"folder.obj", "pipe.obj"}) {
    EXPECT_NE(refusalOf(name).find("exists and was not written by t4d"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace t4d::platform
