#pragma once

#include <array>

#include "measure/triangle_tree.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// The places with a winding number of 1 or more of a closed surface, such as a silhouette, which
/// other surfaces are to enclose.
class EnclosedPlaces {
 public:
  /// `surface` must have at least one triangle, and outlive this.
  explicit EnclosedPlaces(const model::TriangleMesh& surface);

  /// The least distance between the surface and `mesh`, at most `enough`, if a closed `mesh`
  /// encloses the places; 0 if it does not. It is not more than the true one, except for rounding.
  ///
  /// A distance of r > 0 proves that `mesh` has a winding number of 1 or more at all places within
  /// r of these. Since the surfaces do not meet, the winding number of each is constant on every
  /// connected part of the other, so one vertex of each part tells it. If that of the surface is 0
  /// on all of `mesh`, then `mesh` does not pass through places within r. Each connected part of
  /// those has a part of the surface in it, and with it one winding number of `mesh`.
  double margin(const model::TriangleMesh& mesh, double enough) const;

 private:
  double leastDistance(const model::TriangleMesh& mesh, double enough) const;
  double longestPiece(const std::array<model::Point3, 3>& piece) const;

  const model::TriangleMesh& surface_;
  model::Bounds3 bounds_;
  double pieceLength_;  // of triangles near the surface, so that boxes about them are small
  TriangleTree tree_;
};

}  // namespace t4d::measure
