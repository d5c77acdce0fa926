#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/geometry.h"

namespace t4d::voxel4d {

/// A part of a solid that ends between two frames, although one of like size begins near it there:
/// most likely it moves by its own width or more, and between the frames it shrinks or vanishes.
struct LostPart {
  std::size_t frame = 0;                        ///< the last that has it
  double time = 0;                              ///< of that frame
  model::Point3 point = model::Point3::Zero();  ///< its centroid there
  std::uint64_t voxels = 0;                     ///< lattice points inside of it there
};

struct LostParts {
  static constexpr std::size_t kMostListed = 1000;

  std::uint64_t count = 0;
  std::vector<LostPart> listed = {};  ///< the first, in the order of frames, in a frame the largest

  /// Adds those of another body.
  void add(const LostParts& other) {
    count += other.count;
    const std::size_t room = kMostListed - listed.size();
    listed.insert(
        listed.end(), other.listed.begin(),
        other.listed.begin() + static_cast<std::ptrdiff_t>(std::min(room, other.listed.size())));
  }
};

}  // namespace t4d::voxel4d
