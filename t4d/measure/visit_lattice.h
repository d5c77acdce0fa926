#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

/// Winding numbers of a closed surface at the points of a lattice, exact and in memory that grows
/// with the surface.
///
/// Triangles are met with the lines of the lattice by exact signs. A point that lies on a triangle,
/// an edge or a vertex counts as moved by (e, e^2, e^3) for an e smaller than any number
/// (simulation of simplicity), so that every point is on one side, the same for lines in all
/// directions.
namespace t4d::measure {

/// The points of a lattice in space, spaced evenly and equally along all axes.
struct SpaceLattice {
  double spacing = 1;
  std::array<std::vector<double>, 3> at;  ///< coordinates, increasing, at least two along each axis

  /// A lattice about the middle of `bounds` that encloses them. Their sides are a quarter of a
  /// spacing or more away from lattice planes. Fails if there are more than kMostPoints along an
  /// axis, and if coordinates are too large for the spacing.
  static Result<SpaceLattice> about(const model::Bounds3& bounds, double spacing);

  static constexpr std::uint32_t kMostPoints = 1U << 20;

  /// The number of the first point along an axis that is not below a value, or is above it; the
  /// number of points if there is none.
  std::uint32_t firstFrom(int axis, double value) const;
  std::uint32_t firstAfter(int axis, double value) const;

  std::uint64_t pointCount() const {
    return std::uint64_t{at[0].size()} * at[1].size() * at[2].size();
  }

 private:
  template <class ComesBefore>
  std::uint32_t firstNear(int axis, double value, ComesBefore comesBefore) const;
};

/// A point of a lattice, or the lower end of an edge, or the lowest corner of a cube.
using LatticeIndex = std::array<std::uint32_t, 3>;

/// Orders indices by x, then y, then z.
constexpr std::uint64_t keyOf(const LatticeIndex& i) {
  return std::uint64_t{i[0]} << 42 | std::uint64_t{i[1]} << 21 | i[2];
}
constexpr LatticeIndex indexOf(std::uint64_t key) {
  constexpr std::uint64_t kMask = (1U << 21) - 1;
  return {static_cast<std::uint32_t>(key >> 42), static_cast<std::uint32_t>(key >> 21 & kMask),
          static_cast<std::uint32_t>(key & kMask)};
}

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
                                 std::span<const Edge> wanted,
                                 const model::Progress& progress) const;
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
  std::vector<std::uint64_t> columnEnds_;  // of the runs of each column along z
  std::vector<Run> runs_;
  std::array<std::vector<LatticeCrossing>, 3> crossings_;
};

}  // namespace t4d::measure
