#pragma once

#include <span>
#include <vector>

#include "t4d/surface.h"

namespace t4d::voxel4d {

/// A surface in two parts, by its sides: a side is outside where the winding number is zero.
struct UnionSurface {
  std::vector<model::Point3> points;  ///< those of the mesh, then those of cuts
  /// The boundary of the solid: one side is outside, or both sides of sheets that cancel each
  /// other.
  std::vector<model::Triangle> outer;
  /// The triangles within the solid: neither side is outside.
  std::vector<model::Triangle> inner;
};

/// Whether parts of a closed surface are likely to lie within the solid, without a look at each
/// pair of triangles: if an edge has more than two triangles, or if the bounds of two components
/// overlap. A component that overlaps itself is not found.
bool hasOverlappingComponents(std::span<const model::Point3> points,
                              std::span<const model::Triangle> triangles, double tolerance);

/// Splits the surface of a closed mesh into what bounds the union of all that it encloses and what
/// lies within the union, such as the faces of solids inside one another and those along which
/// solids touch. Triangles are cut where others cross or end on them. If no part is within, all
/// triangles are `outer`, as they are.
///
/// What is closer together than `tolerance` counts as touching, and triangles that are narrower
/// than it are left out. A surface that crosses itself in more than half a million places, which is
/// none of solids, is left as it is: all triangles are `outer`.
UnionSurface unionSurface(std::span<const model::Point3> points,
                          std::span<const model::Triangle> triangles, double tolerance);

}  // namespace t4d::voxel4d
