#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::measure {

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

/// A corner of a cube, by its number x + 2 y + 4 z.
constexpr LatticeIndex cornerOf(const LatticeIndex& low, unsigned corner) {
  return {low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2 & 1)};
}

/// The corners of cubes, in increasing order.
std::vector<std::uint64_t> allCornersOf(std::span<const std::uint64_t> cubes);

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

  model::Point3 place(const LatticeIndex& point) const {
    return {at[0][point[0]], at[1][point[1]], at[2][point[2]]};
  }

  std::uint64_t pointCount() const {
    return std::uint64_t{at[0].size()} * at[1].size() * at[2].size();
  }

 private:
  template <class ComesBefore>
  std::uint32_t firstNear(int axis, double value, ComesBefore comesBefore) const;
};

/// The cubes of a lattice for which, and for all blocks of cubes around which, `mayMeet` is true:
/// keys of their lowest corners, increasing. A block has `size` cubes along each axis, a power of
/// two, and may go beyond the end of the lattice. `mayMeet` is called on all threads.
Result<std::vector<std::uint64_t>> cubesThatMeet(
    const SpaceLattice& lattice,
    const std::function<bool(const LatticeIndex& low, std::uint32_t size)>& mayMeet,
    const model::Progress& progress = {});

}  // namespace t4d::measure
