#pragma once

#include <cstddef>

#include "t4d/surface.h"

namespace t4d::edit {

/// False in a build without meshoptimizer.
bool reducesSurfaces();

struct ReducedSurface {
  model::TriangleMesh mesh;
  double error = 0;  ///< about how far it is from the other surface, in length units
};

/// A closed surface with some of the vertices of another one and, if possible, no more than
/// `triangles` triangles, made by meshoptimizer: edges collapse in the order of their quadric
/// errors, without moving vertices. Its triangles may cross. It has no attributes.
///
/// Needs reducesSurfaces().
ReducedSurface reducedSurface(const model::TriangleMesh& mesh, std::size_t triangles);

}  // namespace t4d::edit
