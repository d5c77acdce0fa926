#pragma once

#include "model/union_find.h"
#include "t4d/surface.h"

namespace t4d::model {

/// The connected components of a surface, as sets of its vertices: triangles with a common vertex
/// are of one component. A vertex of no triangle is a set alone.
inline UnionFind componentsOf(const TriangleMesh& mesh) {
  UnionFind sets(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    sets.unite(a, b);
    sets.unite(b, c);
  }
  return sets;
}

}  // namespace t4d::model
