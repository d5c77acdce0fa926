#pragma once

#include "t4d/surface.h"

namespace t4d::measure {

/// The distance from `other` within which the given fraction of the surface of `mesh` lies, by
/// area, in length units. Computed from some ten thousand points spread evenly over the surface,
/// the same ones every time. Unlike the largest distance (surface_distance.h) it does not depend on
/// a single corner. `fraction` is from 0 to 1. 0 if either mesh is empty.
double distanceQuantile(const model::TriangleMesh& mesh, const model::TriangleMesh& other,
                        double fraction);

}  // namespace t4d::measure
