#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "tools/t4d/duration.h"
#include "tools/t4d/members.h"
#include "tools/t4d/test_moving_cube.h"
#include "tools/t4d/transform.h"

namespace t4d::tools {

void addDuration(CLI::App& app, int& exitCode);  // as for each line of the table of verbs

namespace {

/// The verb of CONTRIBUTING.md, whose files are taken from there.
TEST(Contributing, TheVerbOfTheExampleRuns) {
  const platform::TestFolder folder;
  const std::string path = (folder / "cube.t4d").string();
  const model::Mesh mesh = movingCube(0, 4);
  ASSERT_TRUE(transform(inMemory("cube", mesh), {.output = path, .generator = "test"}));
  const auto found = duration(path);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->duration, 4);
  EXPECT_EQ(reportText(*found), "{\n  \"duration\": 4.0\n}");
  CLI::App app;
  int exitCode = -1;
  addDuration(app, exitCode);
  testing::internal::CaptureStdout();
  app.parse("duration " + path, /*program_name_included=*/false);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "4\n");
  EXPECT_EQ(exitCode, 0);
}

}  // namespace
}  // namespace t4d::tools
