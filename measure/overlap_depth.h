#pragma once

#include <optional>
#include <vector>

#include "measure/common_parts.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// How deep two solids lie in each other. Both must outlive this.
class OverlapDepth {
 public:
  OverlapDepth(const model::TriangleMesh& a, const model::TriangleMesh& b)
      : a_(a), b_(b), parts_(commonParts(a, b)) {}

  /// No depth is larger: a ball finds room in the bounds of a common part.
  double most() const;

  /// The largest distance of a point in both solids from both surfaces, less a length for each, to
  /// a fiftieth: a lower bound. 0 if it is no more than `least`, or than what rounding of
  /// coordinates makes of faces that touch. With `any`, the first depth above that.
  double greatest(double lessA = 0, double lessB = 0, bool any = false, double least = 0) const;

 private:
  /// How deep a point is in a solid: negative outside of it.
  struct Depth {
    double value = 0;
    bool isSure = false;  ///< or else it may be outside of the solid
  };
  static Depth depthOf(const model::Point3& point, double distance, const WindingNumber& winding,
                       double enough, const Depth& near, double away);

  /// What tells distances from a surface, and its sides.
  struct Solid {
    explicit Solid(const model::TriangleMesh& mesh) : tree(mesh), winding(mesh) {}
    TriangleTree tree;
    WindingNumber winding;
  };

  const model::TriangleMesh& a_;
  const model::TriangleMesh& b_;
  std::vector<CommonPart> parts_;
  // Made where they are needed.
  mutable std::optional<Solid> solidA_;
  mutable std::optional<Solid> solidB_;
};

}  // namespace t4d::measure
