#include "tools/bench/collided_meshes.h"

#include <utility>

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "fixtures/solids.h"
#include "t4d/collide.h"
#include "t4d/sweep.h"

namespace t4d::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

constexpr int kFrames = 1000;

/// The frames in which two surfaces meet, of kFrames evenly spaced. The tree of the first is built
/// once; the second is moved in its place, relative to the first.
int framesWithContact(const model::TriangleMesh& a, const model::Motion& motionOfA,
                      const model::TriangleMesh& b, const model::Motion& motionOfB) {
  Surface surface;
  for (const model::Point3& p : a.vertices) surface.add_vertex({p.x(), p.y(), p.z()});
  for (const auto& [p, q, r] : a.triangles) {
    surface.add_face(Surface::Vertex_index(p), Surface::Vertex_index(q), Surface::Vertex_index(r));
  }
  Tree tree(faces(surface).begin(), faces(surface).end(), surface);
  tree.build();
  const double begin = motionOfA.timeBegin();
  const double length = motionOfA.timeEnd() - begin;
  int found = 0;
  std::vector<Kernel::Point_3> points(b.vertices.size());
  for (int frame = 0; frame < kFrames; ++frame) {
    const double time = begin + length * frame / (kFrames - 1);
    const model::Pose of = motionOfA.at(time);
    const model::Pose back{of.rotation.transpose(), -(of.rotation.transpose() * of.translation)};
    const model::Pose relative = back * motionOfB.at(time);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const model::Point3 p = relative(b.vertices[i]);
      points[i] = {p.x(), p.y(), p.z()};
    }
    for (const auto& [p, q, r] : b.triangles) {
      if (!tree.do_intersect(Kernel::Triangle_3(points[p], points[q], points[r]))) continue;
      ++found;
      break;
    }
  }
  return found;
}

Result<model::Motion> straight(double duration, const Eigen::Vector3d& by) {
  model::ScrewRun run;
  run.duration = duration;
  run.screw.translation = by;
  return model::chainScrews(0, {&run, 1});
}

}  // namespace

Result<void> measureCollidedMeshes(const model::TriangleMesh& solid, const model::Motion& motion,
                                   double minVolumeRatio, Report& report) {
  // The other one comes the same way from the other end, a little beside.
  const model::Bounds3 bounds = boundsOf(solid);
  const double height = bounds.max.y() - bounds.min.y();
  const double length = motion.timeEnd() - motion.timeBegin();
  const Eigen::Vector3d way = motion.at(motion.timeEnd()).translation;
  const auto back = straight(length, -way);
  if (!back) return back.error();
  const model::TriangleMesh other =
      fixtures::translated(solid, way + Eigen::Vector3d(0, 0.1 * height, 0.05 * height));
  const mesh4d::SweepOptions how{.steps = mesh4d::MinVolumeRatio{minVolumeRatio},
                                 .caps = mesh4d::CapMethod::Cone};
  model::Mesh a;
  model::Mesh b;
  const auto swept = mesh4d::sweep(solid, motion, how, a);
  if (!swept) return swept.error();
  mesh4d::SweepOptions sameSteps = how;
  sameSteps.steps = mesh4d::StepsPerSegment{swept->steps};
  if (auto done = mesh4d::sweep(other, *back, sameSteps, b); !done) return done.error();
  bool contact = false;
  int frames = 0;
  report.rows.push_back(compare(
      report.repetitions, "collide, exact and between frames",
      [&] { contact = measure::collide(a, b, {.overlapVolumes = false})->contact(); },
      "1,000 frames with CGAL's tree of boxes",
      [&] { frames = framesWithContact(solid, motion, other, *back); }));
  report.figures.push_back(
      {"cells of each body", static_cast<double>(swept->tetrahedra) / 1e6, "million"});
  report.figures.push_back({"contact is found", contact ? 1.0 : 0.0, ""});
  report.figures.push_back({"frames with contact", static_cast<double>(frames), ""});

  // Thinner than it goes in a frame.
  const auto still = straight(1, Eigen::Vector3d::Zero());
  const auto shot = straight(1, {1000, 0, 0});
  if (!still || !shot) return (still ? shot : still).error();
  const model::TriangleMesh bullet =
      fixtures::translated(fixtures::cube(0.02), {-500, 0.001, 0.002});
  model::TriangleMesh plate = fixtures::cube(1);
  for (model::Point3& vertex : plate.vertices) vertex.x() *= 0.01;
  model::Mesh bullets;
  model::Mesh plates;
  if (auto done = mesh4d::sweep(bullet, *shot, how, bullets); !done) return done.error();
  if (auto done = mesh4d::sweep(plate, *still, how, plates); !done) return done.error();
  const auto hit = measure::collide(bullets, plates);
  if (!hit) return hit.error();
  report.figures.push_back({"a bullet through a plate: contacts by collide",
                            static_cast<double>(hit->intervals.size()), ""});
  report.figures.push_back({"the same: frames with contact",
                            static_cast<double>(framesWithContact(plate, *still, bullet, *shot)),
                            ""});
  return {};
}

}  // namespace t4d::bench
