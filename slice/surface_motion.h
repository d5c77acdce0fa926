#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slice/cut.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::slice {

/// The outward normal of a triangle, with the area as its length.
model::Point3 areaVector(const model::TriangleMesh& mesh, const model::Triangle& triangle);

/// SurfaceMotion::speeds for a cut of these cells at a time.
std::vector<double> speedsOf(const Cut& cut, std::span<const model::Cell> cells,
                             std::span<const model::Point4> vertices);

/// The velocity of vertex i of both layers of a slab of prisms, along the segment from its position
/// in the lower layer to that in the upper layer.
model::Point3 layerVelocity(const model::Slab& slab, std::uint32_t i);

/// SurfaceMotion::velocities for a cut of a slab of prisms. The velocity of a mean is the mean of
/// those of its sources; that of a point of the cut is interpolated along its edge at its fraction.
std::vector<model::Point3> velocitiesOf(const Cut& cut, std::span<const double> fractions,
                                        const model::Slab& slab);

}  // namespace t4d::slice
