#pragma once

#include <cstdint>
#include <vector>

#include "t4d/surface.h"

namespace t4d::measure {

/// One of the connected surfaces of a closed triangle mesh.
struct ConnectedSurface {
  /// The genus by Euler's formula V - E + F = 2 - 2 genus. A surface that touches itself at a
  /// vertex is not a manifold. Each such place makes this 1/2 smaller than if the surface were
  /// joined there, so it may be fractional or negative.
  double genus = 0;
  double volume = 0;         ///< that it encloses; negative if it faces inward
  std::uint32_t vertex = 0;  ///< one of its vertices
};

/// Vertices without a triangle do not count.
std::vector<ConnectedSurface> surfacesOf(const model::TriangleMesh& mesh);

/// The genus of each, in descending order.
std::vector<double> generaOf(const model::TriangleMesh& mesh);

}  // namespace t4d::measure
