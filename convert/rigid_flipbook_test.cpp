#include "convert/rigid_flipbook.h"

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/check.h"
#include "t4d/convert.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

model::Mesh screwed(double degrees, std::uint64_t steps) {
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  options.steps = mesh4d::StepsPerSegment{steps};
  model::Screw screw;
  screw.axisPoint = {1, 2, 0};
  screw.axisDirection = Eigen::Vector3d(1, 2, 2) / 3;
  screw.angleDegrees = degrees;
  screw.translation = {1, 2, 3};
  const model::ScrewRun run{1, screw, 1};
  model::Mesh mesh;
  EXPECT_TRUE(
      mesh4d::sweep(fixtures::torus(3, 1, 9, 5), *model::chainScrews(0, {&run, 1}), options, mesh));
  return mesh;
}

TEST(RigidMotion, IsTheSolidAtLayersAndNearItBetween) {
  const model::Mesh mesh = screwed(200, 4);
  const auto motion = rigidMotionOf(mesh);
  ASSERT_TRUE(motion) << motion.error().text();
  EXPECT_EQ(motion->solid.triangles, fixtures::torus(3, 1, 9, 5).triangles);
  ASSERT_EQ(motion->layers.size(), 5U);
  double farthest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& [time, pose] = motion->layers[i];
    const auto layer = slice::sliceAtTime(mesh, time);
    for (std::size_t v = 0; v < layer->mesh.vertices.size(); ++v) {
      EXPECT_EQ(model::posed(pose, motion->solid.vertices[v]), layer->mesh.vertices[v]);
    }
    for (const double fraction : {0.25, 0.5, 0.8}) {
      const auto& next = motion->layers[i + 1];
      const Eigen::Quaterniond from(Eigen::Matrix3d(pose.leftCols<3>()));
      const Eigen::Quaterniond to(Eigen::Matrix3d(next.pose.leftCols<3>()));
      const model::Point3 place = (1 - fraction) * model::posed(pose, motion->center) +
                                  fraction * model::posed(next.pose, motion->center);
      model::TriangleMesh played = motion->solid;
      for (model::Point3& point : played.vertices) {
        point = from.slerp(fraction, to) * (point - motion->center) + place;
      }
      const auto exact = slice::sliceAtTime(mesh, time + fraction * (next.time - time));
      const double found = measure::surfaceDistance(played, exact->mesh, 1e-3).hausdorff();
      EXPECT_LE(found, motion->distance);
      farthest = std::max(farthest, found);
    }
  }
  EXPECT_GT(farthest, motion->distance / 5);
}

TEST(RigidMotion, OfASolidThatIsNotRigidIsRefused) {
  const auto why = [](const model::Source& source) {
    const auto motion = rigidMotionOf(source);
    EXPECT_FALSE(motion);
    return motion ? std::string() : motion.error().message;
  };
  const model::TriangleMesh cube = fixtures::cube(2);
  mesh4d::SweepOptions cones;
  cones.caps = mesh4d::CapMethod::Cone;
  model::Mesh deformed;
  ASSERT_TRUE(mesh4d::sweep(cube, model::StoredKeys({{0, cube.vertices}, {1, cube.vertices}}),
                            cones, deformed));
  EXPECT_EQ(why(deformed), "at time 0, the file has no pose");
  mesh4d::SweepOptions three = cones;
  three.prism = mesh4d::PrismSplit::Three;
  const model::ScrewRun rest{1, {}, 1};
  model::Mesh staircase;
  ASSERT_TRUE(mesh4d::sweep(cube, *model::chainScrews(0, {&rest, 1}), three, staircase));
  EXPECT_NE(why(staircase).find("does not consist of prisms"), std::string::npos);
  EXPECT_EQ(why(model::Mesh()), "it has no steps");
  const model::Mesh turned = screwed(90, 2);
  model::Mesh lying;
  for (model::Slab slab : turned.slabs()) {
    if (slab.timeEnd == 1) slab.upperPose = nullptr;
    ASSERT_TRUE(lying.put(slab));
  }
  EXPECT_EQ(why(lying), "at time 1, the file has no pose");
}

TEST(RigidFlipbook, IsKilobytesForAnyNumberOfFrames) {
  const model::Mesh mesh = screwed(200, 40);
  const model::Body body{"torus", &mesh};
  const platform::TestFolder folder;
  const auto bytes = [&](std::uint64_t frames) {
    const auto path = folder / "a.glb";
    const auto report = writeRigidFlipbook({&body, 1}, model::evenTimes({0, 1}, frames), path);
    EXPECT_TRUE(report) << report.error().text();
    EXPECT_EQ(report->frames, frames);
    EXPECT_EQ(report->triangles, 90U);
    return std::filesystem::file_size(path);
  };
  EXPECT_LT(bytes(10), 6000U);
  EXPECT_LT(bytes(5000), 6000U);
  EXPECT_FALSE(writeRigidFlipbook({&body, 1}, std::vector<double>{0, 2}, folder / "b.glb"));
  EXPECT_FALSE(writeRigidFlipbook({&body, 1}, std::vector<double>{0, 1}, folder / "b.ply"));
}

}  // namespace
}  // namespace t4d::convert
