#pragma once

#include <vector>

#include "t4d/model/triangle_mesh.h"

namespace t4d::measure {

/// The genus of each connected surface of a closed triangle mesh, in descending order, from Euler's
/// formula V - E + F = 2 - 2 genus. Vertices without a triangle do not count.
///
/// A surface that touches itself at a vertex is not a manifold. Each such place makes the result
/// 1/2 smaller than if the surface were joined there, so it may be fractional or negative.
std::vector<double> generaOf(const model::TriangleMesh& mesh);

}  // namespace t4d::measure
