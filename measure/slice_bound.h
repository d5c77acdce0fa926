#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Some cells of a 4D mesh.
struct CellSet {
  std::span<const model::Point4> vertices;
  std::span<const model::Cell> cells;
};

/// Cells with which slices are compared.
///
/// The proof that a cell is near to them at all times: a piece of it is
///
/// * if its four corners are near to the same tetrahedron: the points that are, at their own time,
///   within a distance of a tetrahedron are the Minkowski sum of it and a ball in space, which is
///   convex;
/// * or if tetrahedra that face the same way and are near enough along a direction in space cover
///   it, seen along that direction: none of the facets where these tetrahedra end is seen in front
///   of the piece, so as many are seen at each of its points, and at one there is one. Where they
///   end a little before it does, as at an edge, the piece is moved by as much.
///
/// Cells are split until each piece is: if a tetrahedron is near to all corners that lie within its
/// times, at the time at which it begins or ends; else in half.
class SliceBound {
 public:
  /// Cells at one time are left out: they are in no slice. Those with the vertices of a facet in
  /// common are neighbours.
  explicit SliceBound(const CellSet& to);
  ~SliceBound();
  SliceBound(SliceBound&&) noexcept;
  SliceBound& operator=(SliceBound&&) noexcept;

  /// Whether a point is within a distance of their slice at its time.
  bool isNear(const model::Point4& point, double distance) const;

  /// Cells for which it could not be proved that no slice of them, at any time, has a point farther
  /// than `distance` from the slice of these at that time; in increasing order. If there are none,
  /// it is proved, up to rounding. Runs on all threads; the result does not depend on their number.
  std::vector<std::uint32_t> notProvedNear(const CellSet& cells, double distance) const;

 private:
  class Tetrahedra;
  class Proof;
  std::unique_ptr<const Tetrahedra> to_;
};

}  // namespace t4d::measure
