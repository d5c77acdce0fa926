#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "model/attribute.h"
#include "model/geometry.h"

namespace t4d::model {

using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh in space: the input of a sweep, or a slice. Triangles of a solid's surface are
/// counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Point3> vertices = {};
  std::vector<Triangle> triangles = {};
  /// Domain::Cell means one row per triangle.
  std::vector<Attribute> attributes = {};
};

Bounds3 boundsOf(const TriangleMesh& mesh);

/// The volume that a closed mesh encloses, positive if its triangles face outward. Summed about the
/// centre of the bounds, so that a mesh far from the origin loses no precision.
double signedVolume(const TriangleMesh& mesh);

double surfaceArea(const TriangleMesh& mesh);

/// True if every edge is traversed equally often in both directions, so that the mesh bounds a
/// solid. The empty mesh is closed.
bool isClosed(const TriangleMesh& mesh);

}  // namespace t4d::model
