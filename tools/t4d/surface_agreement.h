#pragma once

#include "t4d/surface.h"

namespace t4d::tools {

/// How far two surfaces are apart on the whole, in length units. Unlike the largest distance, these
/// do not depend on a single corner.
struct SurfaceAgreement {
  /// The mean distance of the points of each from the other, over the area of both.
  double meanDistance = 0;
  /// The larger of two distances: that within which 95 % of the area of one is from the other.
  double hausdorff95 = 0;
};

/// Measures the agreement at measure::kSurfaceSamples points of each surface. 0 if both are empty,
/// infinite if one is.
SurfaceAgreement surfaceAgreement(const model::TriangleMesh& a, const model::TriangleMesh& b);

}  // namespace t4d::tools
