#include "platform/scratch_file.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

/// Sets TMPDIR for as long as it lives.
class TmpDir {
 public:
  explicit TmpDir(const std::string& folder) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    setenv("TMPDIR", folder.c_str(), 1);
  }
  TmpDir(const TmpDir&) = delete;
  TmpDir& operator=(const TmpDir&) = delete;
  ~TmpDir() {
    unsetenv("TMPDIR");
    if (!before_.empty()) setenv("TMPDIR", before_.c_str(), 1);
  }

 private:
  std::string before_;
};

TEST(ScratchFile, GivesBackWhatWasAppendedAndHasNoName) {
  const TestFolder folder;
  const TmpDir set(folder.path().string());
  auto file = ScratchFile::create();
  ASSERT_TRUE(file);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const std::array<int, 5> numbers = {2, 3, 5, 7, 11};
  ASSERT_TRUE(file->append(std::as_bytes(std::span(numbers).first(2))));
  ASSERT_TRUE(file->append(std::as_bytes(std::span(numbers).subspan(2))));
  std::array<int, 3> middle{};
  EXPECT_TRUE(file->read(sizeof(int), std::as_writable_bytes(std::span(middle))));
  EXPECT_EQ(middle, (std::array{3, 5, 7}));
  EXPECT_FALSE(file->read(3 * sizeof(int), std::as_writable_bytes(std::span(middle))));
}

TEST(ScratchFile, FailsWithTheReason) {
  const TmpDir set("/nowhere");
  const auto file = ScratchFile::create();
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message,
            "cannot make a temporary file (TMPDIR says where): No such file or directory");
}

}  // namespace
}  // namespace t4d::platform
