// First contacts by FCL at 4,000 poses of the true motion, with those of the swept meshes. (Its
// conservative advancement is not taken: for the ring, which meets the cube at 7/12, it says 0.69.)
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <fcl/narrowphase/continuous_collision.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/collide.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using Eigen::Vector3d;
using model::Screw;
using model::TriangleMesh;

std::shared_ptr<fcl::CollisionGeometryd> geometryOf(const TriangleMesh& mesh) {
  auto geometry = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  std::vector<fcl::Vector3d> vertices(mesh.vertices.begin(), mesh.vertices.end());
  std::vector<fcl::Triangle> triangles;
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  geometry->beginModel();
  geometry->addSubModel(vertices, triangles);
  geometry->endModel();
  return geometry;
}

fcl::Transform3d poseOf(const model::Motion& motion, double time) {
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.matrix().topRows<3>() = motion.at(time).matrix();
  return pose;
}

struct Encounter {
  const char* name;
  TriangleMesh moving;
  Screw screw;
  TriangleMesh still;
  double speed;  // of approach where they meet, at least
};

Screw turn(const Vector3d& axis, double degrees, const Vector3d& along = Vector3d::Zero()) {
  Screw screw;
  screw.axisDirection = axis;
  screw.angleDegrees = degrees;
  screw.translation = along;
  return screw;
}

TEST(CollideAndFcl, AgreeOnTheFirstContactOfRigidMotions) {
  const auto far = [](TriangleMesh mesh, const Vector3d& by) {
    return fixtures::translated(std::move(mesh), by);
  };
  const std::vector<Encounter> encounters = {
      {"cubes", fixtures::cube(2), turn(Vector3d::UnitX(), 0, {5, 0.3, 0.2}),
       far(fixtures::cube(2), {6, 0.5, 0}), 5},
      {"balls", fixtures::icosphere(1, 2), turn(Vector3d::UnitX(), 0, {4, 1, 0}),
       far(fixtures::icosphere(1, 2), {4, 0.5, 0.3}), 2},
      {"a cube that turns about the origin", far(fixtures::cube(2), {5, 0, 0}),
       turn(Vector3d::UnitZ(), 120), far(fixtures::cube(2), {0, 5, 0.5}), 4},
      {"a ball on a screw into a pebble", far(fixtures::icosphere(1, 2), {4, 0, 0}),
       turn(Vector3d::UnitZ(), 100, {0, 0, 1}), far(fixtures::icosphere(1, 2), {0, 4, 1}), 4},
      {"a ring", far(fixtures::torus(3, 1, 24, 12), {9, 0, 0}),
       turn(Vector3d::UnitX(), 0, {-6, 0, 0}), fixtures::cube(3), 6},
  };
  for (const Encounter& encounter : encounters) {
    SCOPED_TRACE(encounter.name);
    const model::ScrewRun run{1, encounter.screw, 1};
    const auto motion = model::chainScrews(0, {&run, 1});
    ASSERT_TRUE(motion);
    const model::ScrewRun rest{1, Screw{}, 1};
    const auto still = model::chainScrews(0, {&rest, 1});
    const mesh4d::SweepOptions how{.steps = mesh4d::StepsPerSegment{64},
                                   .caps = mesh4d::CapMethod::Cone};
    model::Mesh a;
    model::Mesh b;
    ASSERT_TRUE(mesh4d::sweep(encounter.moving, *motion, how, a));
    ASSERT_TRUE(mesh4d::sweep(encounter.still, *still, how, b));
    const auto found = collide(a, b, {.clearance = false, .overlapVolumes = false});
    ASSERT_TRUE(found);
    ASSERT_TRUE(found->contact());

    const auto kind = encounter.screw.angleDegrees == 0 ? fcl::CCDM_LINEAR : fcl::CCDM_SCREW;
    fcl::ContinuousCollisionRequestd request(4000, 1e-5, kind, fcl::GST_LIBCCD, fcl::CCDC_NAIVE);
    fcl::ContinuousCollisionResultd result;
    const auto movingGeometry = geometryOf(encounter.moving);
    const auto stillGeometry = geometryOf(encounter.still);
    fcl::continuousCollide(movingGeometry.get(), poseOf(*motion, 0), poseOf(*motion, 1),
                           stillGeometry.get(), fcl::Transform3d::Identity(),
                           fcl::Transform3d::Identity(), request, result);
    ASSERT_TRUE(result.is_collide);
    double reach = 0;
    for (const auto& vertex : encounter.moving.vertices) reach = std::max(reach, vertex.norm());
    const double angle = encounter.screw.angleDegrees * std::numbers::pi / 180 / 64;
    const double bound = reach * (1 - std::cos(angle / 2)) + 4 * std::sin(angle / 2) / 6;
    EXPECT_NEAR(found->intervals.front().begin, result.time_of_contact,
                bound / encounter.speed + 1.0 / 4000);
  }
}

}  // namespace
}  // namespace t4d::measure
