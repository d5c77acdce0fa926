#include "measure/slice_bound.h"

#include <random>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::measure {
namespace {

struct FlatCells {
  std::vector<model::Point4> vertices;
  std::vector<model::Cell> cells;

  CellSet set() const { return {vertices, cells}; }
};

FlatCells flatCellsOf(const model::Source& source) {
  const auto flat = model::flatten(source);
  FlatCells made;
  for (Eigen::Index i = 0; i < flat->vertices.rows(); ++i) {
    made.vertices.emplace_back(flat->vertices.row(i).transpose());
  }
  for (Eigen::Index i = 0; i < flat->cells.rows(); ++i) {
    made.cells.push_back(
        {flat->cells(i, 0), flat->cells(i, 1), flat->cells(i, 2), flat->cells(i, 3)});
  }
  return made;
}

std::vector<FlatCells> boundSamples() {
  std::vector<FlatCells> list;
  model::Mesh swept;
  const auto motion = fixtures::allMotions()[3];
  EXPECT_TRUE(mesh4d::sweep(fixtures::icosphere(2, 0), *formats::parseMotion(motion.json, "m"),
                            {mesh4d::StepsPerSegment{3}, mesh4d::CapMethod::Cone}, swept));
  list.push_back(flatCellsOf(swept));
  const fixtures::Field field = fixtures::translatingSphere(1.5, {1, 1, 0});
  model::Mesh woven;
  const auto frames = voxel4d::sampledFrames(field.value, {}, field.box,
                                             model::evenTimes({field.timeBegin, field.timeEnd}, 3),
                                             {.slope = field.slope});
  EXPECT_TRUE(voxel4d::weave(*frames, {}, woven));
  list.push_back(flatCellsOf(woven));
  return list;
}

TEST(SliceBound, AMeshIsNearToItself) {
  for (const FlatCells& mesh : boundSamples()) {
    for (const double distance : {1e-9, 0.01, 0.1}) {
      EXPECT_TRUE(SliceBound(mesh.set()).notProvedNear(mesh.set(), distance).empty()) << distance;
    }
  }
}

TEST(SliceBound, WhatIsMovedInSpaceIsNearExactlyUpToTheWay) {
  for (const FlatCells& mesh : boundSamples()) {
    FlatCells moved = mesh;
    for (model::Point4& vertex : moved.vertices) vertex[0] += 0.1;
    EXPECT_TRUE(SliceBound(moved.set()).notProvedNear(mesh.set(), 0.12).empty());
    EXPECT_TRUE(SliceBound(mesh.set()).notProvedNear(moved.set(), 0.12).empty());
    EXPECT_FALSE(SliceBound(moved.set()).notProvedNear(mesh.set(), 0.09).empty());
  }
}

TEST(SliceBound, WhatIsShakenIsNear) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-0.03, 0.03);
  for (const FlatCells& mesh : boundSamples()) {
    FlatCells moved = mesh;
    for (model::Point4& vertex : moved.vertices) {
      for (int k = 0; k < 3; ++k) vertex[k] += shake(random);
    }
    EXPECT_TRUE(SliceBound(moved.set()).notProvedNear(mesh.set(), 0.06).empty());
    EXPECT_TRUE(SliceBound(mesh.set()).notProvedNear(moved.set(), 0.06).empty());
  }
}

/// Where a cell is missing, what lay there is near to nothing but its border.
TEST(SliceBound, AHoleIsNoticed) {
  for (const FlatCells& mesh : boundSamples()) {
    const SliceBound whole(mesh.set());
    for (std::size_t missing = 0; missing < mesh.cells.size(); missing += 211) {
      FlatCells holed = mesh;
      const auto cell = holed.cells.begin() + static_cast<std::ptrdiff_t>(missing);
      const double time = mesh.vertices[(*cell)[0]][3];
      const bool isInSlices = std::ranges::any_of(
          *cell, [&](std::uint32_t corner) { return mesh.vertices[corner][3] != time; });
      holed.cells.erase(cell);
      const auto lost = SliceBound(holed.set()).notProvedNear(mesh.set(), 1e-4);
      EXPECT_EQ(std::ranges::count(lost, missing), isInSlices ? 1 : 0) << missing;
      EXPECT_TRUE(whole.notProvedNear(holed.set(), 1e-4).empty());
    }
  }
}

TEST(SliceBound, APointIsNearAsFarAsItsSlice) {
  for (const FlatCells& mesh : boundSamples()) {
    const SliceBound bound(mesh.set());
    const model::Point4 vertex = mesh.vertices[mesh.vertices.size() / 2];
    EXPECT_TRUE(bound.isNear(vertex, 1e-12));
    EXPECT_TRUE(bound.isNear(vertex + model::Point4(0.05, 0, 0, 0), 0.051));
    EXPECT_FALSE(bound.isNear(vertex + model::Point4(0, 0, 0, 1000), 1));
  }
}

}  // namespace
}  // namespace t4d::measure
