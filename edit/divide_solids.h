#pragma once

#include <vector>

#include "edit/mend_deformation.h"

namespace t4d::edit {

/// A solid of several that were one mesh.
struct MovingSolid {
  model::TriangleMesh mesh;
  Runs runs;
};

/// Divides a closed surface into its connected components, in the order of their first triangles; a
/// component that faces inward at the first key is a cavity, and belongs to the smallest of those
/// around it. They share the keys. Attributes come along. Fails if reading the first key does.
Result<std::vector<MovingSolid>> divideSolids(const model::TriangleMesh& mesh, Runs runs);

}  // namespace t4d::edit
