#include "tools/t4d/mill.h"

#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "conformance/backends/milling.h"
#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/surface.h"
#include "tools/t4d/input.h"
#include "tools/t4d/members.h"

namespace t4d::tools {
namespace {

using nlohmann::json;

/// A cube and a flat tool that cuts a slot into its top.
class Milling : public testing::Test {
 protected:
  void SetUp() override {
    formats::NamedMesh cube;
    cube.mesh = fixtures::cube(10);
    ASSERT_TRUE(formats::writeTriangleMeshes(pathOf("cube.obj"), std::vector{cube}));
    const model::Bounds3 bounds = model::boundsOf(cube.mesh);
    const double y = (bounds.min.y() + bounds.max.y()) / 2;
    std::ofstream(pathOf("slot.nc"))
        << "G21 G90 F600\n"
        << "G0 X" << bounds.min.x() - 5 << " Y" << y << " Z" << bounds.max.z() - 2 << "\nG1 X"
        << bounds.max.x() + 5 << "\n";
    files_.stock.path = pathOf("cube.obj");
    files_.tools = {{0, {"flat:d=4,l=20"}}};
    files_.kind = ToolPathKind::Gcode;
    files_.path = pathOf("slot.nc");
    options_.voxelSize = 0.5;
    options_.frames = {.count = 5};
    options_.output.path = pathOf("slot.t4d");
  }

  std::string pathOf(const char* name) const { return (folder_ / name).string(); }

  platform::TestFolder folder_;
  MillFiles files_;
  MillOptions options_;
};

TEST_F(Milling, RemovesWhatTheToolPassesThrough) {
  const auto input = readMilling(files_, options_);
  ASSERT_TRUE(input) << input.error().text();
  const auto report = mill(*input, options_);
  ASSERT_TRUE(report) << report.error().text();
  // A slot 4 wide, 2 deep and 10 long.
  EXPECT_NEAR(report->milled.removedVolume, 80, 8);
  EXPECT_EQ(report->motion.lengthUnit, "mm");
  EXPECT_TRUE(report->losses.empty());
  const json value = json::parse(reportText(*report));
  EXPECT_EQ(value["frames"], 5);
  EXPECT_GT(value["peak_bytes"], 1'000'000);
  EXPECT_TRUE(value["mountings"].empty());
  EXPECT_EQ(value["bytes"], std::filesystem::file_size(options_.output.path));
  const auto file = openInput(options_.output.path);
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->metadata.bodies.front().name, "cube");
  const json details = json::parse(file->metadata.detailsJson);
  EXPECT_EQ(details["source"],
            (json{{"mesh", "cube.obj"}, {"tool", "flat:d=4,l=20"}, {"path", "slot.nc"}}));
  EXPECT_EQ(details["parameters"]["tolerance"], 0.005);
}

TEST_F(Milling, SaysThatNothingIsRemoved) {
  std::ofstream(pathOf("away.nc")) << "G21 G90 F600\nG0 X0 Y0 Z100\nG1 X5\n";
  files_.path = pathOf("away.nc");
  const auto input = readMilling(files_, options_);
  ASSERT_TRUE(input) << input.error().text();
  const auto report = mill(*input, options_);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->notices.size(), 1);
  EXPECT_TRUE(report->notices.front().starts_with(files_.path + ": nothing is removed"));
}

TEST_F(Milling, RefusesToolsThatNothingMountsAndAnOutputThatIsTheStock) {
  MillFiles none = files_;
  none.tools.clear();
  EXPECT_EQ(readMilling(none, options_).error().code, ErrorCode::Options);
  MillFiles numbered = files_;
  numbered.tools = {{2, {"flat:d=4,l=20"}}};
  numbered.kind = ToolPathKind::Motion;
  EXPECT_EQ(readMilling(numbered, options_).error().code, ErrorCode::Options);
  const auto input = readMilling(files_, options_);
  ASSERT_TRUE(input) << input.error().text();
  options_.output.path = files_.stock.path;
  EXPECT_EQ(mill(*input, options_).error().code, ErrorCode::Options);
}

}  // namespace
}  // namespace t4d::tools
