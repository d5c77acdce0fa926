#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "t4d/surface.h"

namespace t4d::formats {

/// A mesh whose vertices have one normal each: where several meet, the vertex is repeated.
struct VerticesWithNormals {
  std::vector<std::uint32_t> sources;  ///< for each of them, the vertex of the mesh
  std::vector<Eigen::Vector3f> normals;
  std::vector<model::Triangle> triangles;  ///< those of the mesh, of these vertices
};

/// A normal is the mean of those of the triangles that share it, weighted by their angles at the
/// vertex, which does not depend on how a polygon is divided. Of length 1, also where all triangles
/// are flat: there it is any.
VerticesWithNormals withNormals(const model::TriangleMesh& mesh, const NormalStyle& style);

/// The normals that the vertices of `layout` have in a mesh with the same triangles and other
/// places: shared by the same triangles.
std::vector<Eigen::Vector3f> normalsWhenMoved(const VerticesWithNormals& layout,
                                              const model::TriangleMesh& mesh);

/// One vertex for each of the mesh, without normals.
VerticesWithNormals withoutNormals(const model::TriangleMesh& mesh);

}  // namespace t4d::formats
