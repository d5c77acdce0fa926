#include "platform/temporary_folder.h"

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

namespace t4d::platform {
namespace {

TEST(TemporaryFolder, FailsWithTheReason) {
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before == nullptr ? "" : before;
  setenv("TMPDIR", "/nowhere", 1);
  const auto folder = TemporaryFolder::create();
  if (before == nullptr) unsetenv("TMPDIR");
  if (before != nullptr) setenv("TMPDIR", kept.c_str(), 1);
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().message,
            "cannot make a temporary folder (TMPDIR says where): No such file or directory");
}

}  // namespace
}  // namespace t4d::platform
