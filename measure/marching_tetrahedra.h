#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/space_lattice.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// Values at some points of a lattice.
struct LatticeValues {
  std::vector<std::uint64_t> points = {};  ///< their keys, increasing
  std::vector<double> values = {};         ///< of each point
};

/// The surface where a function has the value `level`; the side below is inside. The cubes of the
/// lattice are cut into six tetrahedra each, in which the function is linear between its values at
/// the corners: the surface is closed, oriented and manifold, and does not cross itself.
///
/// `cubes` are the keys of the cubes' lowest corners; all those that the surface passes through
/// must be among them, and their corners must have values. A corner whose value is `level` is
/// inside. Vertices keep `margin`, a part of the edge that they are on, away from its ends.
/// Fails if it is told to stop.
Result<model::TriangleMesh> marchingTetrahedra(const SpaceLattice& lattice,
                                               std::span<const std::uint64_t> cubes,
                                               const LatticeValues& values, double level,
                                               double margin, const model::Progress& progress = {});

}  // namespace t4d::measure
