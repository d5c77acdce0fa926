#pragma once

#include <vector>

#include "measure/common_parts.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// How deep two solids lie in each other. Both must outlive this.
class OverlapDepth {
 public:
  OverlapDepth(const model::TriangleMesh& a, const model::TriangleMesh& b);

  /// The largest distance of a point in both solids from both surfaces, less a length for each, to
  /// a fiftieth: a lower bound. 0 if it is no more than what rounding of coordinates makes of faces
  /// that touch. With `any`, the first depth above that.
  double greatest(double lessA = 0, double lessB = 0, bool any = false) const;

 private:
  double at(const model::Point3& point, double lessA, double lessB, double most) const;

  TriangleTree treeA_;
  TriangleTree treeB_;
  WindingNumber windingA_;
  WindingNumber windingB_;
  std::vector<CommonPart> parts_;
  double largest_ = 0;  // coordinate of what both bounds have in common
};

}  // namespace t4d::measure
