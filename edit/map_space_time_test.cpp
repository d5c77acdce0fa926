#include "edit/map_space_time.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/motion.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::edit {
namespace {

Eigen::Matrix4d permutation(std::array<int, 4> axes, std::array<int, 4> signs) {
  Eigen::Matrix4d map = Eigen::Matrix4d::Zero();
  for (int row = 0; row < 4; ++row) map(row, axes[row]) = signs[row];
  return map;
}

// All 384 ways to exchange and reverse axes: a few of each kind.
TEST(MapSpaceTime, KeepsTheMeshClosedOutwardAndItsHypervolume) {
  model::Mesh swept;
  const auto motion = formats::parseMotion(
      R"({"segments":[{"duration":2,"translation":[0.5,0,3],"axis_point":[0,0,0],
          "axis_direction":[0,0,1],"angle_degrees":40}]})",
      "motion");
  ASSERT_TRUE(motion);
  ASSERT_TRUE(mesh4d::sweep(fixtures::torus(4, 1.5, 12, 8), *motion,
                            {mesh4d::StepsPerSegment{5}, mesh4d::CapMethod::Cone}, swept));
  const auto before = measure::checkMesh(swept);
  ASSERT_TRUE(before && before->valid());
  std::array<int, 4> axes = {0, 1, 2, 3};
  int number = 0;
  do {
    std::array<int, 4> signs{};
    for (int i = 0; i < 4; ++i) signs[i] = (number * 7 >> i & 1) != 0 ? -1 : 1;
    ++number;
    const Eigen::Matrix4d map = permutation(axes, signs);
    const auto mapped = mapSpaceTime(swept, map);
    ASSERT_TRUE(mapped) << mapped.error().text();
    const auto after = measure::checkMesh(mapped->cut.mesh);
    ASSERT_TRUE(after) << after.error().text();
    EXPECT_TRUE(after->valid() && after->closed && after->oriented);
    EXPECT_NEAR(after->hypervolume, before->hypervolume, 1e-10 * before->hypervolume);
    EXPECT_EQ(after->vertices, before->vertices);
    // A slice at a time is the slice of the mesh before across the axis that became time.
    const double at = 0.3;
    const auto slice = slice::slice(mapped->cut.mesh, slice::Hyperplane::atTime(at));
    const auto across = slice::slice(swept, {map.row(3).transpose(), at});
    ASSERT_EQ(slice.has_value(), across.has_value());
    if (!slice) continue;  // before time began
    EXPECT_NEAR(std::abs(model::signedVolume(slice->mesh)),
                std::abs(model::signedVolume(across->mesh)), 1e-9);
    EXPECT_GE(model::signedVolume(slice->mesh), 0);
  } while (std::next_permutation(axes.begin(), axes.end()));
}

TEST(MapSpaceTime, RefusesAMapThatFlattens) {
  model::Mesh nothing;
  EXPECT_FALSE(mapSpaceTime(nothing, Eigen::Matrix4d::Zero()));
}

}  // namespace
}  // namespace t4d::edit
