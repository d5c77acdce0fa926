#pragma once

#include <optional>

#include "measure/visit_lattice.h"

namespace t4d::measure {

/// A point of a silhouette that is not near any lattice point inside: none of the 64 about it. The
/// solid there is too thin for the lattice. Nothing if there is none among the vertices and points
/// of the triangles that are about a spacing apart.
std::optional<model::Point3> missedPoint(const model::TriangleMesh& silhouette,
                                         const VisitLattice& visits);

}  // namespace t4d::measure
