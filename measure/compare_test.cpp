#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/converted_source.h"
#include "t4d/check.h"
#include "t4d/convert.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

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

TEST(Compare, TimesAmidStepsDoNotBeatWithThem) {
  for (const std::uint64_t steps : {1, 2, 3, 4, 5, 7, 8, 9, 12, 20, 25, 355}) {
    SCOPED_TRACE(steps);
    model::ScrewRun run;
    run.duration = 3;
    run.screw.angleDegrees = 40.0 * static_cast<double>(steps);
    model::Mesh mesh;
    ASSERT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(-1, {&run, 1}),
                              {.steps = mesh4d::StepsPerSegment{steps}}, mesh));
    const model::Body body{"turning", &mesh};
    const auto times = timesAmidSteps({&body, 1}, {-1, 2}, 9);
    ASSERT_EQ(times.size(), steps < 3 ? 9 : std::min<std::size_t>(9, steps + 2));
    EXPECT_EQ(times.front(), -1);
    EXPECT_EQ(times.back(), 2);
    EXPECT_TRUE(std::ranges::is_sorted(times, std::less_equal<>()));
    // Four times or more in a step show what happens in it.
    if (steps < 3) {
      EXPECT_EQ(times, model::evenTimes({-1, 2}, 9));
      continue;
    }
    for (std::size_t i = 1; i + 1 < times.size(); ++i) {
      if (steps >= 8) {
        EXPECT_NEAR(times[i], -1 + 3.0 * static_cast<double>(i) / 8,
                    3.0 / static_cast<double>(steps));
      }
      const auto slice = slice::sliceAtTime(mesh, times[i]);
      ASSERT_TRUE(slice);
      EXPECT_NEAR(signedVolume(slice->mesh), 8 * (1 + std::cos(40 * M_PI / 180)) / 2, 1e-9);
    }
  }
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
