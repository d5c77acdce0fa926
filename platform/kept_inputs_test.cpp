#include "platform/kept_inputs.h"

#include <optional>

#include <gtest/gtest.h>

#include "platform/part_file.h"
#include "platform/regular_file.h"
#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

class KeptInput : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("a", "text");
    fs::create_hard_link(folder_ / "a", folder_ / "hard");
    fs::create_symlink("a", folder_ / "soft");
  }

  /// The reason why a file cannot be written under a name; "" if it can.
  std::string errorOf(const char* name) const {
    auto part = PartFile::create(folder_ / name);
    return part ? "" : part.error().text();
  }

  TestFolder folder_;
};

TEST_F(KeptInput, IsNotReplacedUnderAnyOfItsNames) {
  const KeptInputs run;
  ASSERT_TRUE(sizeOfRegularFile(folder_ / "soft"));
  for (const char* name : {"a", "hard", "soft"}) {
    EXPECT_EQ(errorOf(name),
              (folder_ / name).string() + ": is an input of this run; name another output");
  }
  EXPECT_EQ(errorOf("b"), "");
}

TEST_F(KeptInput, IsNotReplacedByAnOutputThatWasCreatedBefore) {
  const KeptInputs run;
  auto part = PartFile::create(folder_ / "hard");
  ASSERT_TRUE(part && part->write("new"));
  noteInput(folder_ / "a");
  const auto put = PartFile::putInPlace({&*part, 1});
  ASSERT_FALSE(put);
  EXPECT_EQ(put.error().code, ErrorCode::Options);
  EXPECT_EQ(contents(folder_ / "hard"), "text");
}

TEST_F(KeptInput, IsOneUntilAllRunsHaveEnded) {
  std::optional<KeptInputs> outer(std::in_place);
  {
    const KeptInputs inner;
    noteInput(folder_ / "a");
  }
  EXPECT_NE(errorOf("a"), "");
  outer.reset();
  EXPECT_EQ(errorOf("a"), "");
  noteInput(folder_ / "a");
  EXPECT_EQ(errorOf("a"), "");
  const KeptInputs later;
  EXPECT_EQ(errorOf("a"), "");
}

}  // namespace
}  // namespace t4d::platform
