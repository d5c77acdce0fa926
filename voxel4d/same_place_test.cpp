#include "voxel4d/same_place.h"

#include <gtest/gtest.h>

namespace t4d::voxel4d {
namespace {

TEST(VoxelsApart, IsTheDistanceOfTheFarthestCornerInVoxels) {
  model::Affine3x4 place;
  place << 2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 4, 30;
  const Eigen::Vector3d low(0, 0, 0);
  const Eigen::Vector3d high(100, 50, 10);
  EXPECT_EQ(voxelsApart(place, place, low, high), 0);
  model::Affine3x4 moved = place;
  moved(1, 3) += 3;  // everywhere by 3, of which a voxel is 2
  EXPECT_DOUBLE_EQ(voxelsApart(place, moved, low, high), 1.5);
  model::Affine3x4 longer = place;
  longer(0, 0) += 0.01;  // nowhere at x = 0, by 1 at x = 100
  EXPECT_NEAR(voxelsApart(place, longer, low, high), 0.5, 1e-12);
  EXPECT_NEAR(voxelsApart(place, longer, -high, low), 0.5, 1e-12);
}

}  // namespace
}  // namespace t4d::voxel4d
