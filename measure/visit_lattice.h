#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "measure/space_lattice.h"
#include "t4d/surface.h"

/// Winding numbers of a closed surface at the points of a lattice, exact and in memory that grows
/// with the surface.
///
/// Triangles are met with the lines of the lattice by exact signs. A point that lies on a triangle,
/// an edge or a vertex counts as moved by (e, e^2, e^3) for an e smaller than any number
/// (simulation of simplicity), so that every point is on one side, the same for lines in all
/// directions.
namespace t4d::measure {

/// Where a lattice edge passes from places with a winding number below 1 to others. If it does so
/// several times, the place that is nearest to its outer end.
struct LatticeCrossing {
  std::uint64_t key = 0;  ///< of the edge's lower end
  double fraction = 0;    ///< of the edge from there
  model::Point3 normal;   ///< of the surface, outward, of length 1
};

class VisitLattice {
 public:
  /// `surface` must be closed, and its bounds within those that the lattice was made about. Without
  /// crossings there are only the winding numbers, in a third of the time.
  VisitLattice(const model::TriangleMesh& surface, SpaceLattice lattice,
               const model::Progress& progress = {}, bool withCrossings = true);
  /// Fails if it was told to stop; it is of no use then.
  Result<void> checkWhole() const { return whole_; }

  /// About how many bytes the lattice and a surface made from it take.
  static double estimatedBytes(const model::TriangleMesh& surface, const SpaceLattice& lattice);
  /// About how many seconds one core of 3 GHz takes for both, as far as the spacing decides it.
  /// Counted, not measured: the same on every machine.
  static double estimatedSeconds(const model::TriangleMesh& surface, const SpaceLattice& lattice);

  const SpaceLattice& lattice() const { return lattice_; }
  int winding(const LatticeIndex& point) const;
  bool isInside(const LatticeIndex& point) const { return winding(point) >= 1; }
  /// Whether all points of a box are inside, both corners included.
  bool allInside(const LatticeIndex& low, const LatticeIndex& high) const;

  /// The crossings of the edges along an axis, in increasing order of their keys.
  std::span<const LatticeCrossing> crossings(int axis) const { return crossings_[axis]; }

 private:
  struct Event;
  struct Edge;

  std::vector<Event> eventsAlong(const model::TriangleMesh& surface, int axis,
                                 std::span<const Edge> wanted, const model::Progress& progress);
  void setColumns(const std::vector<Event>& events);
  std::vector<Edge> edgesAlong(int axis) const;
  std::vector<LatticeCrossing> crossingsOf(const model::TriangleMesh& surface, int axis,
                                           std::span<const Edge> edges,
                                           std::span<const Event> events) const;

  /// The winding number from the point number `from` of a column on.
  struct Run {
    std::uint32_t from;
    int winding;
  };
  std::span<const Run> column(std::uint32_t x, std::uint32_t y) const;

  SpaceLattice lattice_;
  Result<void> whole_;
  std::vector<std::uint64_t> columnEnds_;  // of the runs of each column along z
  std::vector<Run> runs_;
  std::array<std::vector<LatticeCrossing>, 3> crossings_;
};

}  // namespace t4d::measure
