#pragma once

#include <vector>

#include "t4d/surface.h"

namespace t4d::measure {

/// A part of what two solids have in common: it lies in the hull of `corners`.
struct CommonPart {
  std::vector<model::Point3> corners;  ///< of this part, and perhaps more of its points
  model::Bounds3 bounds;               ///< of the corners
};

/// The least distance of parts along an axis, as a fraction of the extent of both together.
inline constexpr double kLeastGapOfParts = 1.0 / 128;

/// The points that are in both of two solids, in parts that lie apart along an axis. Nothing if
/// their interiors have no common point, and for surfaces that touch from outside up to the
/// rounding of coordinates.
///
/// The common part of two solids is a polyhedron. Its edges are the segments in which triangles of
/// the two surfaces cross, and the pieces of edges of one surface that lie inside the other; its
/// corners are the ends of these. They are found however small it is. Parts are told apart by
/// planes across an axis that no edge crosses.
std::vector<CommonPart> commonParts(const model::TriangleMesh& a, const model::TriangleMesh& b);

}  // namespace t4d::measure
