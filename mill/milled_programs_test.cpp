#include "fixtures/milled_programs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "formats/toolpath/gcode_reader.h"
#include "mill/mill.h"
#include "mill/tool_shape.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::fixtures {

/// For messages, instead of its bytes.
void PrintTo(const MilledProgram& program, std::ostream* out);
void PrintTo(const MilledProgram& program, std::ostream* out) { *out << program.about; }

}  // namespace t4d::fixtures

namespace t4d::mill {
namespace {

using fixtures::MilledProgram;

/// The block that the programs mill.
model::TriangleMesh stock() {
  model::TriangleMesh mesh = fixtures::cube(1);
  for (model::Point3& vertex : mesh.vertices) {
    const model::Point3 low(0.03, 0.07, 0.01);
    const model::Point3 high(40.03, 20.07, 10.01);
    for (int axis = 0; axis < 3; ++axis) vertex[axis] = vertex[axis] < 0 ? low[axis] : high[axis];
  }
  return mesh;
}

formats::ToolPathOptions optionsOf(const MilledProgram& program, double tolerance) {
  formats::ToolPathOptions options{.tolerance = tolerance, .reach = 12};
  options.tools.emplace();
  options.diameters = fixtures::diametersOf(program);
  for (const auto& [number, spec] : program.tools) options.tools->push_back(number);
  for (const auto& [number, length] : program.lengths) options.lengths[number] = {0, 0, length};
  for (const std::string& offset : program.offsets) {
    EXPECT_TRUE(formats::parseOffset(offset, options.offsets)) << offset;
  }
  for (const std::string& rotary : program.rotaries) {
    const auto axis = formats::parseRotaryAxis(rotary);
    EXPECT_TRUE(axis) << rotary;
    if (axis) options.rotaries.push_back(*axis);
  }
  return options;
}

struct MilledVolume {
  double removed = 0;
  double returned = 0;
  std::size_t collisions = 0;
};

MilledVolume volumeOf(const MilledProgram& program, double voxelSize) {
  const double fine = voxelSize / 100;
  const auto path = formats::readGcode(formats::InputFile{program.name + ".nc", program.text},
                                       optionsOf(program, voxelSize / 20));
  EXPECT_TRUE(path) << (path ? "" : path.error().text());
  if (!path) return {};
  std::vector<Tool> tools;
  for (const auto& [number, spec] : program.tools) {
    const auto shape = parseTool(spec);
    EXPECT_TRUE(shape) << spec;
    if (shape) tools.push_back({*toolMesh(*shape, fine), {}, number});
  }
  MillOptions options;
  options.voxelSize = voxelSize;
  options.tolerance = voxelSize / 20;
  options.times = model::evenTimes({path->motion.timeBegin(), path->motion.timeEnd()}, 3);
  for (const formats::Mounting& one : path->mountings) {
    options.mountings.push_back(mountingOf(tools, one.time, one.tool));
  }
  options.rapids = path->rapids;
  model::Mesh mesh;
  const auto milled = mill(stock(), tools, path->motion, options, mesh);
  EXPECT_TRUE(milled) << (milled ? "" : milled.error().text());
  if (!milled) return {};
  EXPECT_TRUE(measure::checkMesh(mesh)->valid());
  return {milled->removedVolume, milled->returnedVolume, milled->collisions.size()};
}

class MilledPrograms : public testing::TestWithParam<MilledProgram> {};

TEST_P(MilledPrograms, RemoveTheirVolume) {
  const MilledProgram& program = GetParam();
  const MilledVolume milled = volumeOf(program, 0.5);
  const double error = std::abs(milled.removed - program.volume);
  RecordProperty("volume", fmt::format("{:.6g}", program.volume));
  RecordProperty("error", fmt::format("{:.3g} %", 100 * error / program.volume));
  EXPECT_LT(error, 0.015 * program.volume) << milled.removed << " instead of " << program.volume;
  EXPECT_EQ(milled.collisions, 0U);
}

std::string nameOf(const testing::TestParamInfo<MilledProgram>& program) {
  std::string name = program.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Gcode, MilledPrograms, testing::ValuesIn(fixtures::milledPrograms()),
                         nameOf);
INSTANTIATE_TEST_SUITE_P(Posts, MilledPrograms, testing::ValuesIn(fixtures::postedPrograms()),
                         nameOf);

}  // namespace
}  // namespace t4d::mill
