#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "t4d/frames.h"

namespace t4d::voxel4d {

/// Finds where solids reach the border of a region and are therefore cut off.
class RegionBorder {
 public:
  RegionBorder() = default;
  /// Takes a region in lattice points: where it has no number, nothing is cut off. `offset`: what
  /// is added to a lattice point to name it.
  explicit RegionBorder(const std::array<IndexRange, 3>& region,
                        const std::array<std::int64_t, 3>& offset = {});

  /// Looks at a frame of which only the region is left.
  void look(const Frame& frame);

  /// Names the sides that were reached; "" if there are none.
  std::string notice() const;

 private:
  /// Points whose coordinate along an axis is `at`, the last that are used.
  struct Side {
    int axis = 0;
    std::int64_t at = 0;
    bool reached = false;
  };

  std::vector<Side> sides_;
  std::array<std::int64_t, 3> offset_{};
};

}  // namespace t4d::voxel4d
