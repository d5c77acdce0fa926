#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Stands in place of the number of an event: none.
inline constexpr std::size_t kNoEvent = ~std::size_t{0};

/// A connected surface of slices, from one change of it to the next.
struct Shell {
  /// The approximate volume at its begin or its last sample in the slab that is being worked on;
  /// else NaN.
  double volume = 0;
  bool outer = true;  ///< it faces outward
  bool alive = true;
  std::int64_t euler2 = 0;  ///< twice its Euler number
  std::uint32_t solid = model::kNoIndex;
  std::size_t appears = kNoEvent;  ///< of a cavity that began within its solid
  /// For a surface since before the first slab of a part of a mesh: its number there.
  std::uint32_t atFirst = model::kNoIndex;
  double largestVolume = 0;
};

/// A component of the slice at a time, with what it consists of just before and just after.
struct Transition {
  std::vector<std::uint32_t> shellsBelow = {};
  std::vector<std::uint32_t> arcsAbove = {};
  std::int64_t change2 = 0;  ///< of twice the Euler number
  model::Point3 placeSum = model::Point3::Zero();
  double placeCount = 0;
  std::uint32_t node = model::kNoIndex;  ///< in the slab, if it has arcs above

  // Found when it is worked on:
  std::vector<std::uint32_t> shellsAbove = {};
  std::vector<std::uint32_t> tracksBefore = {};

  bool isTrivial() const {
    return shellsBelow.size() == 1 && arcsAbove.size() == 1 && change2 == 0;
  }
  model::Point3 place() const {
    return placeCount > 0 ? model::Point3(placeSum / placeCount) : placeSum;
  }
};

}  // namespace t4d::measure
