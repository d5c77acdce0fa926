#pragma once

#include <span>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// The boundary of the convex hull of points (CGAL), facing outward; its vertices are some of them.
/// Fails if all points are in a plane, and in a build without CGAL.
Result<model::TriangleMesh> convexHull(std::span<const model::Point3> points);

}  // namespace t4d::edit
