#include "slice/velocity.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "slice/surface_motion.h"

namespace t4d::slice {
namespace {

using model::Point3;

/// Directions in which the normals at a vertex, squared and weighted, have less than this part of
/// what they have in the main one are taken as tangents. A surface that bends by the angle a
/// between two triangles has tan(a / 2) squared across the bend: an edge of 35 degrees is one. With
/// a third of it, vertices of a woven turning cube were up to twice as fast as the cube, and no
/// nearer to the next slice when they were moved.
constexpr double kFlat = 0.1;

/// Sums over the triangles around a vertex: A n n^T, and A w n.
struct NormalEquations {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  Point3 speeds = Point3::Zero();

  Point3 smallestSolution() const {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(normals);
    const Eigen::Vector3d& sizes = solver.eigenvalues();  // rising
    Point3 solution = Point3::Zero();
    for (int k = 0; k < 3; ++k) {
      if (!(sizes[k] > kFlat * sizes[2])) continue;
      const Point3 axis = solver.eigenvectors().col(k);
      solution += axis * (axis.dot(speeds) / sizes[k]);
    }
    return solution;
  }
};

std::vector<Point3> surfaceVelocities(const model::TriangleMesh& mesh,
                                      std::span<const double> speeds) {
  std::vector<NormalEquations> at(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Point3 vector = areaVector(mesh, mesh.triangles[i]);
    const double area = vector.norm();
    if (!(area > 0)) continue;
    const Eigen::Matrix3d squared = vector * (vector / area).transpose();
    for (const std::uint32_t corner : mesh.triangles[i]) {
      at[corner].normals += squared;
      at[corner].speeds += vector * speeds[i];
    }
  }
  std::vector<Point3> velocities;
  velocities.reserve(at.size());
  for (const NormalEquations& equations : at) velocities.push_back(equations.smallestSolution());
  return velocities;
}

double volumeRate(const model::TriangleMesh& mesh, std::span<const double> speeds) {
  double rate = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const double area = areaVector(mesh, mesh.triangles[i]).norm();
    if (area > 0) rate += area * speeds[i];
  }
  return rate;
}

}  // namespace

Result<VelocityReport> addVelocity(Slice& slice, const VelocityOptions& options) {
  VelocityReport report;
  if (!slice.motion) return report;
  const SurfaceMotion motion = *std::exchange(slice.motion, std::nullopt);
  model::TriangleMesh& mesh = slice.mesh;
  report.volumeRate = volumeRate(mesh, motion.speeds);
  report.ofPoints = !motion.velocities.empty();
  std::vector<Point3> velocities =
      report.ofPoints ? motion.velocities : surfaceVelocities(mesh, motion.speeds);
  for (Point3& velocity : velocities) {
    double speed = velocity.stableNorm();
    if (speed > options.most) {
      velocity *= options.most / speed;
      speed = options.most;
      ++report.clamped;
    }
    velocity *= options.timeUnits;
    speed *= std::abs(options.timeUnits);
    if (!std::isfinite(speed)) {
      return invalid("the velocity of a vertex is beyond the range of doubles");
    }
    report.maxSpeed = std::max(report.maxSpeed, speed);
  }
  if (std::erase_if(mesh.attributes, [](const auto& one) { return one.name == kVelocity; }) > 0) {
    slice.losses.push_back(
        fmt::format("attribute '{}' of the mesh: that of the slice replaces it", kVelocity));
  }
  model::Attribute attribute{std::string(kVelocity), model::Domain::Vertex,
                             model::ScalarType::Float64, 3};
  attribute.values.resize(velocities.size() * sizeof(Point3));
  if (!velocities.empty()) {
    std::memcpy(attribute.values.data(), velocities.data(), attribute.values.size());
  }
  mesh.attributes.push_back(std::move(attribute));
  return report;
}

}  // namespace t4d::slice
