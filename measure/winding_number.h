#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/unit_scale.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// The generalised winding number of a triangle mesh, which may be open, overlap itself or be a
/// heap of triangles: the solid angle under which its triangles are seen, as a fraction of the
/// whole sphere, positive where their outer sides are seen from inside. For a closed surface it is
/// an integer: 1 inside, 0 outside; 2 where two solids overlap. (Jacobson, Kavan and
/// Sorkine-Hornung 2013.) What a triangle adds in its own plane is 0 outside it and undefined on
/// it: subtract it there (`ofTriangle`), and the number is the mean of those on the two sides.
class WindingNumber {
 public:
  /// `mesh` must have at least one triangle. The tree copies the corners.
  explicit WindingNumber(const model::TriangleMesh& mesh);

  /// The contribution of one triangle at a point.
  static double ofTriangle(const std::array<model::Point3, 3>& corners, const model::Point3& point);

  /// The winding number at a point, as a sum over all triangles: exact up to rounding.
  double exactAt(const model::Point3& point) const;
  /// The winding number at a point, exact up to rounding, without a tree: for a few points.
  static double exactAt(const model::TriangleMesh& mesh, const model::Point3& point);

  /// An approximation in which dipoles replace distant groups of triangles (Barill et al. 2018),
  /// within a few hundredths. Triangles near the point add exactly what `ofTriangle` says.
  double at(const model::Point3& point) const;

 private:
  struct Node {
    model::Point3 center = model::Point3::Zero();  ///< of the triangles, weighted by their area
    model::Point3 area = model::Point3::Zero();    ///< sum of their areas times their normals
    double radius = 0;                             ///< of a ball about the centre with all of them
    std::uint32_t first = 0;  // of its triangles; for an inner node, the second child
    std::uint32_t count = 0;  // 0 for an inner node, whose first child is the next node
  };

  void build(std::uint32_t begin, std::uint32_t end);

  model::UnitScale scale_;
  /// The corners of the triangles, in the order of the tree and in the unit of the scale.
  std::vector<std::array<model::Point3, 3>> corners_;
  std::vector<Node> nodes_;
};

}  // namespace t4d::measure
