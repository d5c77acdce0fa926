#pragma once

#include <span>
#include <vector>

#include "edit/vertex_lineage.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// The attributes of a mesh for a surface `after` that was made of it by mending.
///
/// `merged` are the triangles of `before`, in the same order, with merged vertices. `origins` are
/// those of the vertices of `after`, by the numbers in `merged`. It is empty if `after` is a new
/// surface that has no triangle of `before`.
///
/// A triangle of `after` has what the triangle of `before` has that it comes from:
/// * one with the same corners, turned or not, or one that was divided at the middles of its edges;
/// * otherwise one that it is a piece of;
/// * otherwise, as what fills a hole, one that shares an edge or else the first corner with it;
/// * without `origins`, the one nearest to its middle.
///
/// Corners, also of vertex attributes, keep their rows. What fills a hole has at each corner what
/// another triangle has there. New corners have the values of the nearest point of the triangle:
/// floating-point numbers are interpolated, integers are those of its nearest corner. A vertex
/// attribute that has several values at a vertex of `after` becomes one of corners
/// (model::kCornersOf), unless there is one of this name.
std::vector<model::Attribute> carriedAttributes(const model::TriangleMesh& before,
                                                std::span<const model::Triangle> merged,
                                                const model::TriangleMesh& after,
                                                std::span<const VertexOrigin> origins);

}  // namespace t4d::edit
