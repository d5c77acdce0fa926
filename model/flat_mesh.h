#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "model/slab.h"

namespace t4d::model {

/// A whole 4D mesh as two matrices.
struct FlatMesh {
  /// One row (x, y, z, t) per vertex, in time order.
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> vertices;
  /// One row of four vertex indices per tetrahedron, oriented as Cell.
  Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 4, Eigen::RowMajor> cells;
};

/// Joins all slabs of a mesh. The layer between two slabs appears once. Attributes are dropped.
///
/// Fails if the source does, if a lower layer differs from the upper layer of the previous slab, or
/// if the mesh has more than 2^32 - 1 vertices.
Result<FlatMesh> flatten(const Source& source, const Progress& progress = {});

}  // namespace t4d::model
