#pragma once

#include <cstdint>
#include <vector>

#include "measure/visit_lattice.h"

namespace t4d::measure {

/// Visits of a moving solid at the points of a lattice. Rows are in the order of keyOf: x, then y,
/// then z.
struct VisitFields {
  SpaceLattice lattice;
  std::vector<std::int32_t> visits;  ///< how often the point is visited
  std::vector<double> dwell;         ///< how long it is covered
  std::vector<double> first;         ///< when it is covered first; 0 where it never is
  std::vector<double> last;          ///< and last

  std::size_t rowOf(const LatticeIndex& i) const {
    return (i[0] * lattice.at[1].size() + i[1]) * lattice.at[2].size() + i[2];
  }
};

/// Makes the fields of a 4D mesh slab by slab, by the cells whose projections along t cover a
/// point: exits count a visit and end a stay, entries begin one. Which cells cover a point is
/// decided by exact signs, with the same moves of points as in VisitLattice, so that visits are its
/// winding numbers. Several meshes may be put one after another.
class VisitFieldBuilder : public model::Sink {
 public:
  explicit VisitFieldBuilder(SpaceLattice lattice);

  /// Bytes that the fields of a lattice take.
  static double bytesOf(const SpaceLattice& lattice) {
    return static_cast<double>(lattice.pointCount()) * kBytesAPoint;
  }

  Result<void> put(const model::Slab& slab) override;

  /// Call it once, after the last slab.
  VisitFields finish();

 private:
  static constexpr double kBytesAPoint = 3 * sizeof(double) + sizeof(std::int32_t);

  VisitFields fields_;
};

}  // namespace t4d::measure
