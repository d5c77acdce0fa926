#include "mill/mill.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "formats/toolpath/cutter_location_reader.h"
#include "formats/toolpath/gcode_reader.h"
#include "mill/motion_parts.h"
#include "mill/stock_field.h"
#include "mill/tool_shape.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::mill {
namespace {

using model::Point3;
using model::TriangleMesh;

constexpr double kPi = std::numbers::pi;

TriangleMesh box(const Point3& from, const Point3& to) {
  TriangleMesh mesh = fixtures::cube(1);
  for (Point3& vertex : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) vertex[axis] = vertex[axis] < 0 ? from[axis] : to[axis];
  }
  return mesh;
}

TriangleMesh toolOf(const std::string& text, double tolerance) {
  const auto shape = parseTool(text);
  EXPECT_TRUE(shape) << text;
  return *toolMesh(*shape, tolerance);
}

formats::ToolPath gcode(const std::string& text, double tolerance = 1e-3) {
  auto path = formats::readGcode(formats::InputFile{"a.nc", text}, {.tolerance = tolerance});
  EXPECT_TRUE(path) << (path ? "" : path.error().text());
  return path ? *path : formats::ToolPath{};
}

std::vector<Tool> alone(TriangleMesh mesh, std::vector<Guard> guards = {}) {
  return {{std::move(mesh), std::move(guards), 0}};
}

struct Process {
  MillReport report;
  model::Mesh mesh;
};

Process milled(const TriangleMesh& stock, const std::vector<Tool>& tools,
               const formats::ToolPath& path, double voxelSize, std::uint64_t frames) {
  MillOptions options;
  options.voxelSize = voxelSize;
  options.tolerance = voxelSize / 100;
  options.times = model::evenTimes({path.motion.timeBegin(), path.motion.timeEnd()}, frames);
  options.rapids = path.rapids;
  Process process;
  for (const formats::Mounting& one : path.mountings) {
    options.mountings.push_back(mountingOf(tools, one.time, one.tool));
  }
  const auto report = mill(stock, tools, path.motion, options, process.mesh);
  EXPECT_TRUE(report) << (report ? "" : report.error().text());
  if (report) process.report = *report;
  return process;
}

Process milled(const TriangleMesh& stock, const TriangleMesh& tool, const formats::ToolPath& path,
               double voxelSize, std::uint64_t frames) {
  return milled(stock, alone(tool), path, voxelSize, frames);
}

/// The slope of the logarithm of errors over that of sizes, from the first to the last.
double orderOf(const std::vector<std::pair<double, double>>& errors) {
  return std::log(errors.front().second / errors.back().second) /
         std::log(errors.front().first / errors.back().first);
}

/// Mills with smaller and smaller voxels and facets, and expects the removed volume of second
/// order.
void expectSecondOrder(const std::string& tool, const TriangleMesh& stock, const std::string& code,
                       double volume, const std::vector<double>& sizes) {
  std::vector<std::pair<double, double>> errors;
  for (const double h : sizes) {
    const double fine = h * h / 200;
    const Process process = milled(stock, toolOf(tool, fine), gcode(code, fine), h, 3);
    errors.emplace_back(h, std::abs(process.report.removedVolume - volume));
  }
  EXPECT_LT(errors.back().second / volume, 0.01) << tool;
  EXPECT_GT(orderOf(errors), 1.7) << tool;
}

const TriangleMesh kBlock = box({0.03, 0.07, 0.01}, {40.03, 20.07, 10.01});
const std::string kSlot = "G0 X-5 Y10 Z6\nG1 X45 F300\n";

TEST(Mill, ARoundingHasTwoChordsHoweverLargeTheTolerance) {
  // Rings: of the rounding after its two chords, and of the upper end.
  for (const std::string tool : {"ball:d=6,l=30", "bull:d=6,r=1,l=30"}) {
    std::set<double> heights;
    for (const Point3& vertex : toolOf(tool, 100).vertices) heights.insert(vertex.z());
    EXPECT_EQ(heights.size(), 4U) << tool;
  }
}

TEST(Mill, MemoryOfAToolCountsAllBlocksOfItsBox) {
  // A rod along the diagonal meets few of the 201^3 blocks, whose numbers alone take 32 MB.
  TriangleMesh rod = box({-800, -0.01, -0.01}, {800, 0.01, 0.01});
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), Eigen::Vector3d(1, 1, 1));
  for (Point3& vertex : rod.vertices) vertex = turn * vertex;
  const double voxelSize = 924.0 / (200 * 8);
  const double ofBlocks = 4 * std::pow(201, 3);
  EXPECT_FALSE(StockField::checkSize(rod, voxelSize, ofBlocks));
  EXPECT_TRUE(StockField::checkSize(rod, voxelSize, 2 * ofBlocks));
}

TEST(Mill, ASlotIsOfSecondOrder) {
  expectSecondOrder("ball:d=6,l=30", kBlock, kSlot, 40 * (kPi * 9 / 2 + 6 * 1.01), {1, 0.5, 0.25});
  expectSecondOrder("flat:d=6,l=30", kBlock, kSlot, 40 * 6 * 4.01, {1, 0.5});
}

TEST(Mill, ACircularPocketIsOfSecondOrder) {
  // The path of the axis is a circle of radius 5, and 3 about it is cut: a ring from 2 to 8.
  expectSecondOrder("flat:d=6,l=30", kBlock, "G0 X15 Y10 Z20\nG0 Z6\nG3 I5 F600\nG0 Z20\n",
                    4.01 * kPi * (64 - 4), {1, 0.5});
}

TEST(Mill, ATiltedToolCutsItsShadow) {
  // A ball that goes along x, tilted in y: the round end leaves a groove of the same radius, and
  // its cylinder cuts upward along the axis.
  const double tilt = kPi / 6;
  std::vector<std::pair<double, double>> errors;
  for (const double h : {1.0, 0.5}) {
    const double s = std::sin(tilt);
    const double c = std::cos(tilt);
    const auto path = formats::readCutterLocations(
        formats::InputFile{
            "a.cl",
            fmt::format("FEDRAT/600\nGOTO/-8,10,4,0,{0},{1}\nGOTO/48,10,4,0,{0},{1}\n", s, c)},
        {});
    ASSERT_TRUE(path);
    const Process process = milled(kBlock, toolOf("ball:d=6,l=60", h * h / 200), *path, h, 3);
    // In the plane (y, z): a half disc of radius 3 about the centre below its diameter across the
    // axis, and a strip of width 6 along the axis up to the top of the block.
    const double centreZ = 4 + 3 * c;
    // The strip above the diameter, cut by the plane z = top: its mean length is from the centre.
    const double strip = 6 * (10.01 - centreZ) / c;
    const double area = kPi * 9 / 2 + strip;
    errors.emplace_back(h, std::abs(process.report.removedVolume - 40 * area));
  }
  EXPECT_GT(orderOf(errors), 1.7);
}

TEST(Mill, AThroughCutSeparatesTheStockAtTheRightTime) {
  // The flat tool passes x = 40.03 with its front when its axis is at 37.03: 42.03 of 50 mm at 5
  // mm/s. What is left at the far side is a bridge that narrows, and is gone at that time.
  const auto path = gcode("G0 X-5 Y10 Z-1\nG1 X45 F300\n");
  for (const std::uint64_t frames : {3, 12}) {
    const Process process = milled(kBlock, toolOf("flat:d=6,l=30", 0.005), path, 0.5, frames);
    const MillReport& report = process.report;
    EXPECT_EQ(report.components, 2U);
    ASSERT_EQ(report.separations.size(), 1U);
    EXPECT_EQ(report.separations[0].components, 2U);
    const double expected = (40.03 + 5 - 3) / 5;
    // To a step of the tool and a voxel.
    EXPECT_LE(report.separations[0].time.begin, expected);
    EXPECT_GE(report.separations[0].time.end, expected);
    EXPECT_NEAR(report.separations[0].time.end, expected, 0.6);
    EXPECT_EQ(report.progress.front().components, 1U);
    EXPECT_EQ(report.progress.back().components, 2U);
  }
}

TEST(Mill, WhatIsRemovedNeverComesBack) {
  // There and back, over cuts made before, and into the air between them.
  const auto path = gcode(
      "G0 X-5 Y7 Z6\nG1 X20 Y9 F600\nX10 Y15 Z4\nG2 X20 Y15 I5\nG1 X5 Y5 Z5\nG0 Z20\nX30\n"
      "G1 Z2\nX38 Y3\n");
  const Process process = milled(kBlock, toolOf("bull:d=5,r=1,l=30", 0.01), path, 0.5, 24);
  const MillReport& report = process.report;
  EXPECT_LT(report.returnedVolume, 1e-4 * report.removedVolume);
  for (std::size_t i = 1; i < report.progress.size(); ++i) {
    EXPECT_GE(report.progress[i].removedVolume, report.progress[i - 1].removedVolume);
  }
  // Slices, at frames and between: each lies within the one before.
  TriangleMesh before;
  double volumeBefore = 0;
  for (const double time : model::evenTimes({path.motion.timeBegin(), path.motion.timeEnd()}, 47)) {
    const auto slice = slice::sliceAtTime(process.mesh, time);
    ASSERT_TRUE(slice);
    const double volume = model::signedVolume(slice->mesh);
    if (!before.triangles.empty()) {
      EXPECT_LE(volume, volumeBefore * (1 + 1e-12)) << time;
    }
    before = slice->mesh;
    volumeBefore = volume;
  }
  // And each lies within the one before: what they differ by is what their volumes do.
  TriangleMesh earlier;
  for (const std::size_t frame : {0, 8, 16, 23}) {
    const auto slice = slice::sliceAtTime(process.mesh, report.progress[frame].time);
    ASSERT_TRUE(slice);
    if (!earlier.triangles.empty()) {
      const auto difference = measure::solidDifference(earlier, slice->mesh);
      ASSERT_TRUE(difference);
      const double fallen = model::signedVolume(earlier) - model::signedVolume(slice->mesh);
      EXPECT_NEAR(difference->volume, fallen, 2 * difference->error + 1e-4 * fallen);
    }
    earlier = slice->mesh;
  }
  EXPECT_NEAR(volumeBefore, report.remainingVolume, 1e-9 * report.stockVolume);
  EXPECT_TRUE(measure::checkMesh(process.mesh)->valid());
}

TEST(Mill, NoMoreThanItSaysComesBackBetweenFrames) {
  // Frames so near to each other that single lattice points change sides between them.
  const auto path = gcode("G0 X15 Y10 Z20\nG0 Z6\nG3 I5 F600\nG0 Z20\n");
  const Process process = milled(kBlock, toolOf("ball:d=6,l=30", 0.01), path, 1, 200);
  const MillReport& report = process.report;
  EXPECT_GT(report.returnedVolume, 0);
  EXPECT_LT(report.returnedVolume, 0.01 * report.removedVolume);
  // What two solids differ by is what has gone and what has come back.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> times(path.motion.timeBegin(), path.motion.timeEnd());
  for (int i = 0; i < 8; ++i) {
    double early = times(random);
    double late = times(random);
    if (early > late) std::swap(early, late);
    const auto before = slice::sliceAtTime(process.mesh, early);
    const auto after = slice::sliceAtTime(process.mesh, late);
    ASSERT_TRUE(before && after);
    const auto difference = measure::solidDifference(before->mesh, after->mesh);
    ASSERT_TRUE(difference);
    const double fallen = model::signedVolume(before->mesh) - model::signedVolume(after->mesh);
    EXPECT_LE((difference->volume - fallen) / 2, report.returnedVolume + difference->error);
  }
}

TEST(Mill, VolumesAreThoseOfSlices) {
  const Process process = milled(kBlock, toolOf("ball:d=6,l=30", 0.01), gcode(kSlot), 1, 5);
  for (const MillProgress& at : process.report.progress) {
    const auto slice = slice::sliceAtTime(process.mesh, at.time);
    EXPECT_NEAR(model::signedVolume(slice->mesh), process.report.stockVolume - at.removedVolume,
                1e-8);
  }
}

TEST(Mill, TheFirstFrameIsTheStock) {
  const Process process = milled(kBlock, toolOf("ball:d=6,l=30", 0.01), gcode(kSlot), 0.5, 5);
  EXPECT_EQ(process.report.progress.front().removedVolume, 0);
  EXPECT_NEAR(process.report.stockVolume, 8000, 30);
}

TEST(Mill, AStockOfWholeVoxelsIsExactButForItsEdges) {
  // Faces on lattice planes: only the twelve edges are cut off, by triangles of a voxel.
  const TriangleMesh stock = box({0, 0, 0}, {10, 10, 10});
  const Process process =
      milled(stock, toolOf("ball:d=2,l=5", 0.01), gcode("G0 X50 Y50 Z50\nG1 X60 F100"), 1, 2);
  EXPECT_FALSE(process.report.firstCut);
  EXPECT_EQ(process.report.removedVolume, 0);
  EXPECT_NEAR(process.report.stockVolume, 1000 - 120 * 0.5, 10);
}

TEST(Mill, AStockMayOverlapItselfAndBeInsideOut) {
  // Two boxes that overlap count once; in one mesh, as two components.
  TriangleMesh both = box({0.1, 0.1, 0.1}, {10.1, 10.1, 10.1});
  const TriangleMesh other = box({5.1, 0.1, 0.1}, {15.1, 10.1, 10.1});
  for (const auto& [a, b, c] : other.triangles) both.triangles.push_back({a + 8, b + 8, c + 8});
  both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
  const TriangleMesh one = box({0.1, 0.1, 0.1}, {15.1, 10.1, 10.1});
  const TriangleMesh tool = toolOf("ball:d=6,l=30", 0.01);
  const auto path = gcode("G0 X5 Y5 Z20\nG1 Z5 F600\n");
  const Process expected = milled(one, tool, path, 0.5, 3);
  const Process overlapping = milled(both, tool, path, 0.5, 3);
  EXPECT_NEAR(overlapping.report.stockVolume, expected.report.stockVolume, 1e-6);
  EXPECT_NEAR(overlapping.report.removedVolume, expected.report.removedVolume, 1e-6);
  TriangleMesh turned = one;
  for (model::Triangle& triangle : turned.triangles) std::swap(triangle[0], triangle[1]);
  const Process inside = milled(turned, tool, path, 0.5, 3);
  EXPECT_EQ(inside.report.notices.size(), 1U);
  EXPECT_NEAR(inside.report.stockVolume, expected.report.stockVolume, 1e-6);
}

TEST(Mill, ShankAndHolderCollideWhenTheyReachTheStock) {
  // A pocket deeper than the tool: the shank, wider than it, meets the stock when the tip is at
  // 10.01 - 4 = 6.01; from z = 12 down at 1 mm/s, that is after 5.99 s.
  const TriangleMesh flat = toolOf("flat:d=6,l=4", 0.01);
  const std::vector<Guard> wide = {{"shank", *cylinderMesh({8, 10}, 4, 0.01)},
                                   {"holder", *cylinderMesh({20, 10}, 14, 0.01)}};
  const auto path = gcode("G0 X20 Y10 Z12\nG1 Z4 F60\n");
  const Process process = milled(kBlock, alone(flat, wide), path, 0.25, 3);
  ASSERT_EQ(process.report.collisions.size(), 1U);
  const Collision& collision = process.report.collisions[0];
  EXPECT_EQ(collision.part, "shank");
  EXPECT_LE(collision.time.begin, 5.99 + 0.25);
  EXPECT_GE(collision.time.begin, 5.99 - 1);
  EXPECT_EQ(collision.time.end, 8);
  const double radius = (collision.point - Point3(20, 10, collision.point.z())).norm();
  EXPECT_GT(radius, 3 - 0.25);
  EXPECT_LT(radius, 4);
  // A shank as thin as the tool follows into what the tool has cut.
  const std::vector<Guard> thin = {{"shank", *cylinderMesh({6, 10}, 4, 0.01)}};
  EXPECT_TRUE(milled(kBlock, alone(flat, thin), path, 0.25, 3).report.collisions.empty());
}

TEST(Mill, EachToolCutsWhileItIsMounted) {
  // A slot of tool 1, and beside it a hole of tool 2, which also is in the slot's way later.
  formats::ToolPathOptions how{.tolerance = 1e-3};
  how.tools = {1, 2};
  const auto path = formats::readGcode(
      formats::InputFile{"a.nc",
                         "T1 M6\nG0 X-5 Y5 Z6\nG1 X45 F600\nG0 Z20\nT2 M6\nG0 X20 Y14\n"
                         "G98 G81 X20 Z-5 R12 F300\nT0 M6\nG0 Z-5\n"},
      how);
  ASSERT_TRUE(path) << path.error().text();
  const std::vector<Guard> guards = {{"holder", *cylinderMesh({16, 10}, 12, 0.01)}};
  std::vector<std::pair<double, double>> errors;
  for (const double h : {1.0, 0.5, 0.25}) {
    const std::vector<Tool> tools = {{toolOf("flat:d=6,l=30", h * h / 200), {}, 1},
                                     {toolOf("drill:d=5,a=90,l=12", h * h / 200), guards, 2}};
    const Process process = milled(kBlock, tools, *path, h, 5);
    const double volume = 40 * 6 * 4.01 + kPi * 6.25 * 10;
    errors.emplace_back(h, std::abs(process.report.removedVolume - volume));
    // The holder reaches the stock, and is named by its tool; nothing is mounted at the end.
    ASSERT_EQ(process.report.collisions.size(), 1U);
    EXPECT_EQ(process.report.collisions[0].part, "holder");
    EXPECT_EQ(process.report.collisions[0].tool, 2);
  }
  EXPECT_LT(errors.back().second, 5);
  EXPECT_GT(orderOf(errors), 1.5);
}

TEST(Mill, ARapidMoveMustNotCut) {
  const Process process = milled(kBlock, toolOf("ball:d=6,l=30", 0.01),
                                 gcode("G0 X-5 Y10 Z6\nG1 X10 F600\nG0 X20\n"), 1, 4);
  ASSERT_EQ(process.report.collisions.size(), 1U);
  EXPECT_EQ(process.report.collisions[0].part, "tool");
  EXPECT_NEAR(process.report.collisions[0].time.begin, 1.5, 1e-9);
}

TEST(Mill, RefusesWhatCannotBeMilled) {
  const auto path = gcode(kSlot);
  const TriangleMesh tool = toolOf("ball:d=6,l=30", 0.01);
  MillOptions options;
  options.voxelSize = 0.001;
  options.times = {0, 10};
  model::Mesh mesh;
  const auto fine = mill(kBlock, alone(tool), path.motion, options, mesh);
  ASSERT_FALSE(fine);
  EXPECT_NE(fine.error().message.find("more than the limit of 4.00 GB"), std::string::npos);
  TriangleMesh open = kBlock;
  open.triangles.pop_back();
  options.voxelSize = 1;
  const auto refused = mill(open, alone(tool), path.motion, options, mesh);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().remedy, Remedy::Mend);
  EXPECT_EQ(refused.error().where.text(), "stock");
}

TEST(Mill, CutsOfLessThanAVoxelAreCuts) {
  // The slot is narrower than the voxels: no lattice point goes, but the surface sinks.
  const Process process = milled(kBlock, toolOf("flat:d=6,l=30", 0.01), gcode(kSlot), 7, 3);
  EXPECT_EQ(process.report.firstCut.has_value(), process.report.removedVolume > 0);
  ASSERT_EQ(process.report.notices.size(), 2U);
  EXPECT_NE(process.report.notices[0].find("in voxels and of 8000 as a mesh"), std::string::npos);
  EXPECT_EQ(process.report.notices[1].find("the tool is less than two voxels across"), 0U);
}

TEST(TimeAfterTravel, IsThatOfTheWayOrTheEndOfTheMotion) {
  model::ScrewRun away;
  away.duration = 5;
  away.screw.translation = {10, 0, 0};
  const model::ScrewRun rest{2, {}, 1};
  const std::array runs = {away, rest, away};
  const auto motion = model::chainScrews(1, runs);
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(timeAfterTravel(*motion, 1, 4), 3);
  EXPECT_DOUBLE_EQ(timeAfterTravel(*motion, 2, 8), 6);
  EXPECT_DOUBLE_EQ(timeAfterTravel(*motion, 2, 12), 10);  // over the rest
  EXPECT_DOUBLE_EQ(timeAfterTravel(*motion, 2, 100), 13);
  EXPECT_DOUBLE_EQ(timeAfterTravel(*motion, 20, 1), 20);
}

TEST(Mill, VoxelsTooLargeForTheStockOrTooSmallForTheToolAreRefused) {
  const auto path = gcode(kSlot);
  MillOptions options;
  options.voxelSize = 50;
  options.times = {0, 10};
  const TriangleMesh stock = box({1, 1, 1}, {41, 21, 11});
  model::Mesh mesh;
  const auto large = mill(stock, alone(toolOf("flat:d=6,l=30", 0.01)), path.motion, options, mesh);
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("too large for it; 2.5 would do"), std::string::npos)
      << large.error().message;
  options.voxelSize = 2.5;
  EXPECT_TRUE(mill(stock, alone(toolOf("flat:d=6,l=30", 0.01)), path.motion, options, mesh));
  // A thin plate across the lattice: the first sizes that are tried find nothing, either.
  TriangleMesh plate = box({0.4, 0.4, 0.4}, {40.4, 0.8, 40.4});
  for (Point3& at : plate.vertices) at = {at.x() - 0.7 * at.y(), 0.7 * at.x() + at.y(), at.z()};
  options.voxelSize = 60;
  const auto thin = mill(plate, alone(toolOf("flat:d=6,l=30", 0.01)), path.motion, options, mesh);
  ASSERT_FALSE(thin);
  const std::size_t advice = thin.error().message.find("too large for it; ");
  ASSERT_NE(advice, std::string::npos) << thin.error().message;
  options.voxelSize = std::stod(thin.error().message.substr(advice + 18));
  EXPECT_LT(options.voxelSize, 7);
  EXPECT_TRUE(mill(plate, alone(toolOf("flat:d=6,l=30", 0.01)), path.motion, options, mesh));
  for (const char* tool : {"flat:d=1e9,l=30", "flat:d=1e5,l=30"}) {
    options.voxelSize = 0.5;
    const auto refused = mill(stock, alone(toolOf(tool, 1)), path.motion, options, mesh);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where.text(), "tool");
    EXPECT_NE(refused.error().message.find("too large for voxels of 0.5"), std::string::npos);
  }
}

TEST(StockField, NamesThePlaceThatWasDeepestInside) {
  auto stock = StockField::of(box({-10, -10, -10}, {10, 10, 10}), 1, 1e9);
  ASSERT_TRUE(stock);
  // Inside at x = 8 and 9, and from 1 to 3 in y and z: 8 is two deep.
  const TriangleMesh tool = box({7.5, 0.5, 0.5}, {12, 3.5, 3.5});
  const auto met = stock->meet(tool);
  ASSERT_TRUE(met);
  EXPECT_EQ(met->points, 18U);
  EXPECT_EQ(met->point.x(), 8);
  const auto removed = stock->remove(tool);
  ASSERT_TRUE(removed);
  EXPECT_EQ(removed->points, 18U);
  EXPECT_EQ(removed->point.x(), 8);
}

TEST(MotionParts, ThatComeNearAreTakenAndNoOthers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return Point3(unit(random), unit(random), unit(random)); };
  for (int seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::vector<model::ScrewRun> runs(5);
    for (model::ScrewRun& run : runs) {
      run.duration = 1 + unit(random) * 0.9;
      run.screw = {20 * point(), point(), seed % 3 == 0 ? 0 : 200 * unit(random), 40 * point()};
    }
    const auto motion = model::chainScrews(unit(random), runs);
    ASSERT_TRUE(motion);
    const double begin = motion->timeBegin() + 0.3;
    const model::TimeSpan span = {begin, motion->timeEnd() - 0.2};
    const double travel = 0.7;
    const double reach = 3;
    const double size = 5;
    const auto partsOf = [&](const Near& near) {
      std::vector<model::Segment> parts;
      EXPECT_TRUE(visitParts(*motion, span, travel, reach, near, [&](const model::Motion& run) {
        for (std::size_t i = 0; i < run.segments.size(); ++i) {
          parts.push_back(run.segments[i]);
          if (i > 0) {
            EXPECT_EQ(run.segments[i].start.translation, run.segments[i - 1].end.translation);
            EXPECT_EQ(run.segments[i].timeBegin, run.segments[i - 1].timeEnd);
          }
        }
        return Result<void>();
      }));
      return parts;
    };
    const auto all = partsOf([](const Point3&, double) { return true; });
    const auto some = partsOf(
        [&](const Point3& center, double radius) { return center.norm() <= size + radius; });
    EXPECT_EQ(all.front().timeBegin, span.begin);
    EXPECT_EQ(all.back().timeEnd, span.end);
    auto next = some.begin();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i > 0) {
        EXPECT_EQ(all[i].timeBegin, all[i - 1].timeEnd);
      }
      EXPECT_LE((all[i].end.translation - all[i].start.translation).norm(), travel);
      if (next != some.end() && next->timeBegin == all[i].timeBegin) {
        EXPECT_EQ(next->timeEnd, all[i].timeEnd);
        EXPECT_EQ(next->start.matrix(), all[i].start.matrix());
        EXPECT_EQ(next->end.matrix(), all[i].end.matrix());
        ++next;
        continue;
      }
      for (const double s : {0.0, 0.3, 0.6, 1.0}) {
        EXPECT_GT(all[i].at(s).translation.norm(), size + reach);
      }
    }
    EXPECT_EQ(next, some.end());
  }
}

TEST(Mill, FarMovesCostNothingAndChangeNothing) {
  const std::string cut = "G0 X-5 Y10 Z6\nG1 X45 F300\n";
  const std::string away = "G0 Z30\nG1 X1000000000 F900000000\nG2 I-300000 F900000000\n";
  const Process near = milled(kBlock, toolOf("ball:d=6,l=30", 0.005), gcode(cut), 1, 2);
  const Process far = milled(kBlock, toolOf("ball:d=6,l=30", 0.005), gcode(cut + away), 1, 2);
  EXPECT_EQ(far.report.removedVolume, near.report.removedVolume);
  EXPECT_LT(far.report.steps, near.report.steps + 20);
  for (const double seconds : {0.01, 1e6}) {
    const auto path = formats::readCutterLocations(
        formats::InputFile{"a.cl", "FEDRAT/600\nGOTO/-16,0,4\nGOTO/1e70,0,4\nGOTO/16,0,4\n"}, {});
    ASSERT_TRUE(path);
    MillOptions options;
    options.voxelSize = 1;
    options.times = {path->motion.timeBegin(), path->motion.timeBegin() + seconds};
    model::Mesh mesh;
    const auto refused =
        mill(kBlock, alone(toolOf("ball:d=6,l=30", 0.01)), path->motion, options, mesh);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().remedy, Remedy::Motion);
  }
}

TEST(Mill, TurningOnAndOnNearTheStockIsRefused) {
  model::ScrewRun spin;
  spin.duration = 1;
  spin.screw.angleDegrees = 1e12;
  const auto motion = model::chainScrews(0, {&spin, 1});
  MillOptions options;
  options.voxelSize = 1;
  options.times = {0, 1};
  model::Mesh mesh;
  const auto refused = mill(kBlock, alone(toolOf("ball:d=6,l=30", 0.01)), *motion, options, mesh);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().remedy, Remedy::Motion);
  EXPECT_NE(refused.error().message.find("more than 10000000 steps"), std::string::npos);
  // Round it, without coming to it.
  spin.screw.axisPoint = {0, 200, 0};
  spin.screw.axisDirection = {0, 0, 1};
  const auto circling = model::chainScrews(0, {&spin, 1});
  const auto endless = mill(kBlock, alone(toolOf("ball:d=6,l=30", 0.01)), *circling, options, mesh);
  ASSERT_FALSE(endless);
  EXPECT_EQ(endless.error().remedy, Remedy::Motion);
}

TEST(ToolShape, VolumesConvergeFromBelow) {
  const struct {
    const char* text;
    double volume;
  } kTools[] = {{"ball:d=6,l=30", kPi * (18 + 9 * 27)},
                {"flat:d=6,l=30", kPi * 9 * 30},
                {"bull:d=6,r=1,l=30", kPi * 9 * 29 + kPi * (4 + 2 * kPi / 2 + 2.0 / 3)},
                {"drill:d=6,a=90,l=30", kPi * 9 * 28},
                {"vbit:d=6,a=90,l=10", kPi * 9 * 8},
                {"chamfer:d=6,a=90,t=2,l=10", kPi * (9 * 8 + 2 * (1 + 3 + 9) / 3.0)},
                {"taper:d=2,a=45,l=3", kPi * 3 * (1 + 4 + 16) / 3.0},
                // A segment of a sphere up to 1 - sin 45 degrees, and a frustum.
                {"taper:r=1,a=45,l=3", [] {
                   const double s = std::sqrt(0.5);
                   const double h = 1 - s;
                   const double top = s + 3 - h;
                   return kPi * h * h * (3 - h) / 3 +
                          kPi * (3 - h) * (s * s + s * top + top * top) / 3;
                 }()}};
  for (const auto& [text, volume] : kTools) {
    double error = 0;
    for (const double tolerance : {0.01, 0.001}) {
      const double now = volume - model::signedVolume(toolOf(text, tolerance));
      EXPECT_GT(now, 0) << text;
      EXPECT_LT(now, tolerance * 6 * 100) << text;
      if (error > 0) {
        EXPECT_LT(now, error / 5);
      }
      error = now;
    }
  }
}

TEST(ToolShape, HasNoMoreFacetsThanItsToleranceAsksFor) {
  for (const double tolerance : {0.1, 0.01, 0.001}) {
    std::set<double> heights;  // of the rings of the rounded end, and its side
    for (const Point3& vertex : toolOf("ball:d=12,l=40", tolerance).vertices) {
      if (vertex.z() > 0 && vertex.z() < 6 + 1e-9) heights.insert(vertex.z());
    }
    const auto gap = [](std::size_t chords) {
      return 6 * (1 - std::cos(kPi / 4 / static_cast<double>(chords)));
    };
    EXPECT_LE(gap(heights.size()), tolerance * (1 + 1e-9));
    EXPECT_GT(gap(heights.size() - 1), tolerance);
  }
}

TEST(ToolShape, ATooSmallToleranceIsRefusedWithOneThatIsKept) {
  for (const char* text : {"ball:d=6,l=30", "flat:d=6e3,l=30", "bull:d=6,r=1,l=30", "drill:d=6",
                           "taper:r=1,a=45,l=3"}) {
    const auto shape = parseTool(text);
    ASSERT_TRUE(shape);
    for (const double tolerance : {1e-9, 1e-12, 1e-300}) {
      const auto made = toolMesh(*shape, tolerance);
      if (made) {
        EXPECT_LE(made->triangles.size(), kMostToolTriangles);
        continue;
      }
      EXPECT_EQ(made.error().code, ErrorCode::Options);
      const std::string& message = made.error().message;
      const auto at = message.find("a tolerance of ", message.find(';'));
      ASSERT_NE(at, message.npos) << message;
      const double fitting = std::stod(message.substr(at + 15));
      EXPECT_TRUE(toolMesh(*shape, fitting)) << text << ": " << fitting;
      EXPECT_FALSE(toolMesh(*shape, 0.8 * fitting)) << text << ": " << fitting;
    }
  }
  EXPECT_FALSE(cylinderMesh({6, 10}, 0, 1e-13));
}

TEST(ToolShape, SaysWhatIsWrong) {
  const auto error = [](const char* text) {
    const auto tool = parseTool(text);
    return tool ? std::string("no error") : tool.error().message;
  };
  EXPECT_EQ(error("ball:d=6,l=0"), "found 'l=0', expected sizes above zero as in ball:d=6,l=30");
  EXPECT_EQ(error("ball:d=6"), "'d=6' has no l; write it as in ball:d=6,l=30");
  EXPECT_EQ(error("ball:d=6,l=2"),
            "the length l=2 must be more than the height 3 of the rounded end");
  EXPECT_EQ(error("bull:d=6,r=3,l=9"),
            "the rounding r=3 must be below half the diameter d=6; with half of it this is a ball");
  EXPECT_EQ(
      error("reamer:d=6,l=9"),
      "'reamer:d=6,l=9' is not a tool; expected ball:, flat:, bull:, drill:, vbit:, chamfer: or "
      "taper: and sizes, as in ball:d=6,l=30, or the file of a triangle mesh");
  EXPECT_EQ(error("drill:d=6"), "no error");
  EXPECT_EQ(error("drill:d=6,a=180"), "the angle a=180 must be below 180 degrees");
  EXPECT_EQ(error("vbit:d=6,a=90"), "'d=6,a=90' has no l; write it as in vbit:d=6,a=60,t=0.2,l=20");
  EXPECT_EQ(error("vbit:d=6,a=90,l=2"),
            "the length l=2 must be more than the height 3 of the pointed end");
  EXPECT_EQ(error("chamfer:d=6,a=90,t=6,l=9"), "the tip t=6 must be below the diameter d=6");
  EXPECT_EQ(error("taper:d=6,r=1,a=5,l=9"),
            "a taper has either d, the diameter of a flat lower end, or r, the radius of a round "
            "one");
  EXPECT_EQ(error("ball:d=6,d=7,l=9"), "'d=6,d=7,l=9' gives d twice");
  EXPECT_EQ(error("flat:d=6,l=9,q=3"), "'q' is not known here; write it as in flat:d=6,l=30");
  EXPECT_EQ(error("flat:d=6,r=1,l=9"), "'r' is not known here; write it as in flat:d=6,l=30");
  EXPECT_EQ(error("flat:d=,l=9"), "found 'd=', expected sizes above zero as in flat:d=6,l=30");
}

}  // namespace
}  // namespace t4d::mill
