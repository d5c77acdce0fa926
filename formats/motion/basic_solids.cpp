#include "formats/motion/basic_solids.h"

#include <cmath>
#include <numbers>

namespace t4d::formats {
namespace {

using model::Point3;
using model::TriangleMesh;

std::uint32_t lastOf(const TriangleMesh& mesh) {
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

/// Adds a ring of kRoundSides vertices, counterclockwise seen from above.
void addRing(TriangleMesh& mesh, double radius, double z) {
  for (int i = 0; i < kRoundSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRoundSides;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
}

/// Joins rings from the first vertex on, the lower one first.
void joinRings(TriangleMesh& mesh, std::uint32_t lower) {
  const std::uint32_t upper = lower + kRoundSides;
  for (std::uint32_t i = 0; i < kRoundSides; ++i) {
    const std::uint32_t next = (i + 1) % kRoundSides;
    mesh.triangles.push_back({lower + i, lower + next, upper + next});
    mesh.triangles.push_back({lower + i, upper + next, upper + i});
  }
}

/// Closes a ring by the last vertex, which is below it or above it.
void closeRing(TriangleMesh& mesh, std::uint32_t ring, bool above) {
  const std::uint32_t apex = lastOf(mesh);
  for (std::uint32_t i = 0; i < kRoundSides; ++i) {
    const std::uint32_t next = (i + 1) % kRoundSides;
    if (above) {
      mesh.triangles.push_back({ring + i, ring + next, apex});
    } else {
      mesh.triangles.push_back({ring + next, ring + i, apex});
    }
  }
}

}  // namespace

TriangleMesh boxMesh(const Eigen::Vector3d& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Point3 corner((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    mesh.vertices.emplace_back(size.cwiseProduct(corner) / 2);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh cylinderMesh(double radius, double length) {
  TriangleMesh mesh;
  addRing(mesh, radius, -length / 2);
  addRing(mesh, radius, length / 2);
  joinRings(mesh, 0);
  mesh.vertices.emplace_back(0, 0, -length / 2);
  closeRing(mesh, 0, false);
  mesh.vertices.emplace_back(0, 0, length / 2);
  closeRing(mesh, kRoundSides, true);
  return mesh;
}

TriangleMesh sphereMesh(double radius) { return capsuleMesh(radius, 0); }

TriangleMesh capsuleMesh(double radius, double length) {
  constexpr int kRows = kRoundSides / 2;
  TriangleMesh mesh;
  std::uint32_t rings = 0;
  const auto add = [&](int row, double z) {
    const double angle = std::numbers::pi * row / kRows;
    addRing(mesh, radius * std::sin(angle), z - radius * std::cos(angle));
    if (rings > 0) joinRings(mesh, (rings - 1) * kRoundSides);
    ++rings;
  };
  for (int row = 1; row <= kRows / 2; ++row) add(row, -length / 2);
  for (int row = length > 0 ? kRows / 2 : kRows / 2 + 1; row < kRows; ++row) add(row, length / 2);
  mesh.vertices.emplace_back(0, 0, -length / 2 - radius);
  closeRing(mesh, 0, false);
  mesh.vertices.emplace_back(0, 0, length / 2 + radius);
  closeRing(mesh, (rings - 1) * kRoundSides, true);
  return mesh;
}

}  // namespace t4d::formats
