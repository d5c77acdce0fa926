#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/model/slab.h"
#include "t4d/slice/cut.h"
#include "t4d/slice/slice.h"

namespace t4d::slice {

/// Along the outward normal, as long as the area.
model::Point3 areaVector(const model::TriangleMesh& mesh, const model::Triangle& triangle);

/// SurfaceMotion::speeds of what was cut at a time of these cells.
std::vector<double> speedsOf(const Cut& cut, std::span<const model::Cell> cells,
                             std::span<const model::Point4> vertices);

/// The velocity of vertex i of both layers of a slab of prisms: on the segment from its place in
/// the lower layer to that in the upper one.
model::Point3 layerVelocity(const model::Slab& slab, std::uint32_t i);

/// SurfaceMotion::velocities of what was cut of a slab of prisms. A mean moves as the mean of what
/// it is made of, and a point of the cut as its edge has it at its fraction.
std::vector<model::Point3> velocitiesOf(const Cut& cut, std::span<const double> fractions,
                                        const model::Slab& slab);

}  // namespace t4d::slice
