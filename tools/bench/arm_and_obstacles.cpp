#include "tools/bench/arm_and_obstacles.h"

#include <cmath>
#include <memory>
#include <vector>

#include <fcl/narrowphase/continuous_collision.h>

#include "fixtures/solids.h"
#include "t4d/collide.h"
#include "t4d/sweep.h"

namespace t4d::bench {
namespace {

using model::Point3;
using model::TriangleMesh;

constexpr int kFrames = 1000;

TriangleMesh ellipsoid(const Point3& center, const Point3& radii) {
  TriangleMesh mesh = fixtures::icosphere(1, 3);
  for (Point3& vertex : mesh.vertices) vertex = center + radii.cwiseProduct(vertex);
  return mesh;
}

std::vector<TriangleMesh> links() {
  std::vector<TriangleMesh> all;
  for (int i = 0; i < 6; ++i) all.push_back(ellipsoid({1 + 1.2 * i, 0, 0.3 * i}, {0.55, 0.2, 0.2}));
  return all;
}

/// Obstacles on a spiral, some in the way of the arm.
std::vector<TriangleMesh> obstacles() {
  std::vector<TriangleMesh> all;
  for (int i = 0; i < 20; ++i) {
    const double angle = 2.4 * i;
    const double radius = 2 + 0.35 * i;
    all.push_back(ellipsoid({radius * std::cos(angle), radius * std::sin(angle), 0.1 * (i % 12)},
                            Point3::Constant(0.2 + 0.02 * i)));
  }
  return all;
}

Result<std::vector<model::Mesh>> swept(const std::vector<TriangleMesh>& solids,
                                       const model::Motion& motion, std::uint64_t steps) {
  std::vector<model::Mesh> meshes(solids.size());
  for (std::size_t i = 0; i < solids.size(); ++i) {
    auto done = mesh4d::sweep(
        solids[i], motion,
        {.steps = mesh4d::StepsPerSegment{steps}, .caps = mesh4d::CapMethod::Cone}, meshes[i]);
    if (!done) return done.error();
  }
  return meshes;
}

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

std::vector<Geometry> geometriesOf(const std::vector<TriangleMesh>& solids) {
  std::vector<Geometry> all;
  for (const TriangleMesh& mesh : solids) {
    auto geometry = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    const std::vector<fcl::Vector3d> vertices(mesh.vertices.begin(), mesh.vertices.end());
    std::vector<fcl::Triangle> triangles;
    for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
    geometry->beginModel();
    geometry->addSubModel(vertices, triangles);
    geometry->endModel();
    all.push_back(geometry);
  }
  return all;
}

int contactsByFcl(const std::vector<Geometry>& moving, const std::vector<Geometry>& still,
                  const model::Motion& motion) {
  const auto poseAt = [&](double time) {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.matrix().topRows<3>() = motion.at(time).matrix();
    return pose;
  };
  const fcl::Transform3d rest = fcl::Transform3d::Identity();
  const fcl::ContinuousCollisionRequestd request(kFrames, 1e-5, fcl::CCDM_SCREW, fcl::GST_LIBCCD,
                                                 fcl::CCDC_NAIVE);
  int found = 0;
  for (const Geometry& a : moving) {
    for (const Geometry& b : still) {
      fcl::ContinuousCollisionResultd result;
      fcl::continuousCollide(a.get(), poseAt(motion.timeBegin()), poseAt(motion.timeEnd()), b.get(),
                             rest, rest, request, result);
      found += result.is_collide ? 1 : 0;
    }
  }
  return found;
}

}  // namespace

Result<void> measureArmAndObstacles(Report& report) {
  const model::ScrewRun turn{1, {.angleDegrees = 150, .translation = {0, 0, 0.5}}, 1};
  const model::ScrewRun rest{1, {}, 1};
  const auto motion = model::chainScrews(0, {&turn, 1});
  const auto still = model::chainScrews(0, {&rest, 1});
  if (!motion || !still) return (motion ? still : motion).error();
  const auto arm = swept(links(), *motion, 60);
  if (!arm) return arm.error();
  const auto others = swept(obstacles(), *still, 1);
  if (!others) return others.error();
  std::vector<measure::SourcePair> pairs;
  for (const model::Mesh& a : *arm) {
    for (const model::Mesh& b : *others) pairs.push_back({&a, &b});
  }
  const measure::CollideOptions contactsOnly{.clearance = false, .overlapVolumes = false};
  const auto geometriesOfArm = geometriesOf(links());
  const auto geometriesOfOthers = geometriesOf(obstacles());
  std::vector<measure::Collision> collisions;
  int byFcl = 0;
  report.rows.push_back(compare(
      report.repetitions, "collide, contacts of 120 pairs",
      [&] { collisions = *measure::collideAll(pairs, contactsOnly); },
      "FCL's continuous collision, 1,000 steps",
      [&] { byFcl = contactsByFcl(geometriesOfArm, geometriesOfOthers, *motion); }));
  report.rows.push_back(compare(
      report.repetitions, "120 pairs together", [&] { (void)measure::collideAll(pairs); },
      "one by one",
      [&] {
        for (const auto& [a, b] : pairs) (void)measure::collide(*a, *b);
      }));
  double contacts = 0;
  for (const measure::Collision& collision : collisions) contacts += collision.contact() ? 1 : 0;
  report.figures.push_back({"pairs in contact, by collide", contacts, ""});
  report.figures.push_back({"the same by FCL", static_cast<double>(byFcl), ""});
  return {};
}

}  // namespace t4d::bench
