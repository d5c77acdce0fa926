#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/error.h"

namespace t4d::voxel4d {

/// Whole numbers from `begin` up to, but not including, `end`. Without one of them, all there are
/// on that side.
struct IndexRange {
  std::optional<std::int64_t> begin = {};
  std::optional<std::int64_t> end = {};
};

/// The part of frames that is used. Everything beyond it is outside.
struct Region {
  std::array<IndexRange, 3> space = {};  ///< lattice points along x, y and z
  IndexRange time = {};                  ///< frames, counted from 0
};

/// Reads "X0:X1,Y0:Y1,Z0:Z1" or "X0:X1,Y0:Y1,Z0:Z1,T0:T1", in which numbers may be left out. Fails
/// for ranges that are empty or reversed.
Result<Region> parseRegion(std::string_view text);

/// A range of what is counted from 0.
struct Extent {
  std::uint64_t begin = 0;
  std::uint64_t count = 0;
};

/// What a region's range along `axis` ('x', 'y', 'z' or 't') takes of `count` samples or frames.
/// Fails unless it is within them and, of frames, takes two or more. `where` is for errors.
Result<Extent> extentOf(const IndexRange& range, char axis, std::uint64_t count,
                        const std::string& where);

/// Leaves of a vector what an extent within it takes.
template <class Thing>
void keep(std::vector<Thing>& things, const Extent& extent) {
  things.erase(things.begin() + static_cast<std::ptrdiff_t>(extent.begin + extent.count),
               things.end());
  things.erase(things.begin(), things.begin() + static_cast<std::ptrdiff_t>(extent.begin));
}

}  // namespace t4d::voxel4d
