#include "t4d/measure/compare.h"

#include <limits>

#include <gtest/gtest.h>

#include "t4d/convert/flipbook.h"
#include "t4d/fixtures/solids.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/model/converted_source.h"

namespace t4d::measure {
namespace {

/// A cube of side 2 that moves from the origin by `velocity` during t = `begin` to `begin` + 4.
model::Mesh movingCube(double begin, const Eigen::Vector3d& velocity) {
  model::Screw screw;
  screw.translation = velocity;
  const std::vector<model::ScrewRun> runs = {{1, screw, 4}};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  const auto swept =
      mesh4d::sweep(fixtures::cube(2), *model::chainScrews(begin, runs), options, mesh);
  EXPECT_TRUE(swept);
  return mesh;
}

TEST(Compare, OfTwoMovingCubesIsTheClosedFormAtEveryTime) {
  model::Mesh slow = movingCube(0, {0.125, 0, 0});
  model::Mesh fast = movingCube(0, {0.25, 0, 0});
  const model::Body a{"slow", &slow};
  const model::Body b{"fast", &fast};
  const std::vector<double> times = model::evenTimes({0, 4}, 9);
  const auto comparisons = compareAt(std::span(&a, 1), std::span(&b, 1), times);
  ASSERT_TRUE(comparisons) << comparisons.error().text();
  ASSERT_EQ(comparisons->size(), times.size());
  for (const SliceComparison& slice : *comparisons) {
    const double apart = 0.125 * slice.time;
    EXPECT_NEAR(slice.volumeA, 8, 1e-12);
    EXPECT_NEAR(slice.volumeB, 8, 1e-12);
    EXPECT_NEAR(slice.areaA, 24, 1e-12);
    EXPECT_NEAR(slice.areaB, 24, 1e-12);
    EXPECT_NEAR(slice.difference.volume, 8 * apart, slice.difference.error + 1e-12);
    EXPECT_NEAR(slice.distance.hausdorff(), apart, slice.distance.tolerance);
  }
  EXPECT_EQ(comparisons->front().difference.volume, 0);
  EXPECT_EQ(comparisons->front().distance.hausdorff(), 0);
}

TEST(Compare, WhatDoesNotExistAtATimeIsEmpty) {
  model::Mesh early = movingCube(0, {1, 0, 0});
  model::Mesh late = movingCube(2, {1, 0, 0});
  const model::Body a{"early", &early};
  const model::Body b{"late", &late};
  const std::vector<double> times = {1, 3, 7};
  const auto comparisons = compareAt(std::span(&a, 1), std::span(&b, 1), times);
  ASSERT_TRUE(comparisons);
  const auto& [before, during, after] =
      std::array{comparisons->at(0), comparisons->at(1), comparisons->at(2)};
  EXPECT_EQ(before.volumeB, 0);
  EXPECT_NEAR(before.difference.volume, 8, before.difference.error);
  EXPECT_EQ(before.distance.hausdorff(), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(during.distance.hausdorff(), 2, during.distance.tolerance);
  EXPECT_EQ(after.volumeA + after.volumeB, 0);
  EXPECT_EQ(after.distance.hausdorff(), 0);
}

TEST(Compare, TimesThatFallOnLayersAreCounted) {
  model::Mesh mesh = movingCube(0, {1, 0, 0});
  model::Mesh late = movingCube(0.5, {1, 0, 0});
  const std::vector<model::Body> one = {{"one", &mesh}};
  const std::vector<model::Body> two = {{"one", &mesh}, {"late", &late}};
  EXPECT_EQ(timesOnLayers(one, std::vector<double>{0, 1, 2, 4}), 4U);
  EXPECT_EQ(timesOnLayers(one, std::vector<double>{0, 1.5, 3, 5}), 2U);
  // A few units in the last place beside a layer.
  EXPECT_EQ(timesOnLayers(one, std::vector<double>{std::nextafter(1.0, 2), 4.000000000000001}), 2U);
  // Where both exist, only one of them has a layer.
  EXPECT_EQ(timesOnLayers(two, std::vector<double>{0, 1, 2, 4.5}), 2U);
}

TEST(Compare, AMeshInOtherUnitsIsTheSame) {
  model::Mesh mesh = movingCube(0, {1, 0, 0});
  model::ConvertedSource inMetres(mesh, *model::lengthConversion("mm", "m"),
                                  *model::timeConversion("s", "min"));
  model::ConvertedSource back(inMetres, *model::lengthConversion("m", "mm"),
                              *model::timeConversion("min", "s"));
  const model::Body a{"mm", &mesh};
  const model::Body b{"m", &back};
  const std::vector<double> times = {0, 1.25, 2, 4};
  const auto comparisons = compareAt(std::span(&a, 1), std::span(&b, 1), times);
  ASSERT_TRUE(comparisons) << comparisons.error().text();
  for (const SliceComparison& slice : *comparisons) {
    EXPECT_NEAR(slice.volumeB, slice.volumeA, 1e-12);
    EXPECT_NEAR(slice.areaB, slice.areaA, 1e-12);
    EXPECT_NEAR(slice.difference.volume, 0, 1e-12);
    EXPECT_NEAR(slice.distance.hausdorff(), 0, 1e-12);
  }
  // A cubic millimetre is a billionth of a cubic metre, a second a sixtieth of a minute.
  const double hypervolume = checkMesh(mesh)->hypervolume;
  EXPECT_NEAR(checkMesh(inMetres)->hypervolume, hypervolume * 1e-9 / 60, 1e-24);
}

TEST(Compare, BodiesOfOneFileAreOneSolid) {
  model::Mesh one = movingCube(0, {1, 0, 0});
  model::Mesh other = movingCube(0, {-10, 0, 0});
  const std::vector<model::Body> bodies = {{"one", &one}, {"other", &other}};
  const auto solid = solidAt(bodies, 3);
  ASSERT_TRUE(solid);
  EXPECT_NEAR(model::signedVolume(*solid), 16, 1e-12);
  EXPECT_TRUE(model::isClosed(*solid));
}

}  // namespace
}  // namespace t4d::measure
