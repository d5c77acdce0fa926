#pragma once

#include <vector>

#include "t4d/model/triangle_mesh.h"

namespace t4d::measure {

/// The genus of each connected surface of a closed triangle mesh, in descending order, from Euler's
/// formula V - E + F = 2 - 2 genus. Vertices without a triangle do not count.
///
/// A surface that touches itself in a vertex is no manifold; its number here is too small by 1/2
/// for each such place, which no manifold has, or negative.
std::vector<double> generaOf(const model::TriangleMesh& mesh);

}  // namespace t4d::measure
