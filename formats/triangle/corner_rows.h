#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/surface.h"

namespace t4d::formats {

/// The origins of the corners of a mesh's triangles. Corners of a file are numbered in the order of
/// its polygons.
struct FileCorners {
  /// For each triangle of the mesh, the numbers of its corners in the file.
  std::vector<std::array<std::uint64_t, 3>> ofTriangles;
  /// For each corner of the file, the number of its point.
  std::vector<std::uint32_t> points;
};

/// What a file says of its points, or of corners of faces, as an attribute of the mesh: corner c of
/// the file has row `rowOf[c]` of `rows`. If all corners at a vertex have the same row, byte for
/// byte, it is an attribute of vertices; otherwise, as with texture coordinates at a seam, one of
/// triangles, `NAME:corners` (model::kCornersOf). The domain of `rows` is not used. Every row
/// number must be in range, and every vertex in a triangle.
model::Attribute cornerAttribute(const model::Attribute& rows, std::span<const std::uint32_t> rowOf,
                                 const FileCorners& corners, const model::TriangleMesh& mesh);

}  // namespace t4d::formats
