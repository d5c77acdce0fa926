#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/vertex_stars.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// Cells that a connected surface of a slice just after a time goes through.
struct FloodedSurface {
  std::vector<std::uint32_t> cells;
  bool complete = false;
};

/// Finds the surfaces of slices just after times, from some of their cells, without a look at the
/// others of the slab.
class LevelFlood {
 public:
  explicit LevelFlood(const model::Slab& slab)
      : slab_(slab),
        stars_(*slab.connectivity),
        round_(slab.connectivity->cells.size(), 0),
        front_(slab.connectivity->cells.size(), 0) {}

  const VertexStars& stars() const { return stars_; }

  /// The surfaces of those of the cells `from` that go on after the time. They are sought at the
  /// same pace; if `butOne`, until no more than one is incomplete. So a split of a small piece from
  /// a large one takes as long as the small one.
  std::vector<FloodedSurface> surfaces(double time, std::span<const std::uint32_t> from,
                                       bool butOne);

 private:
  bool goesOn(const model::Cell& cell, double time) const;

  const model::Slab& slab_;
  VertexStars stars_;
  std::vector<std::uint32_t> round_;  // in which each cell was found last
  std::vector<std::uint32_t> front_;  // and by which front
  std::uint32_t now_ = 0;
};

}  // namespace t4d::measure
