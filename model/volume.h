#pragma once

#include <span>

#include "t4d/surface.h"

namespace t4d::model {

/// signedVolume of some triangles, about the centre of the bounds of their corners.
double signedVolume(std::span<const Point3> vertices, std::span<const Triangle> triangles);

}  // namespace t4d::model
