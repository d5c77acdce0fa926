#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "t4d/frames.h"

namespace t4d::voxel4d {

/// Numbers by coordinates: a hash table with linear probing, for blocks are looked up many times
/// for each time that they are entered.
class CoordIndex {
 public:
  /// Makes room for `count` coordinates in all.
  void reserve(std::size_t count) {
    entries_.resize(std::bit_ceil(2 * count + 1));
    mask_ = entries_.size() - 1;
  }

  /// `coord` must be new, and there must be room.
  void add(const Coord& coord, std::uint32_t number) {
    std::size_t at = CoordHash{}(coord)&mask_;
    while (entries_[at].next != 0) at = (at + 1) & mask_;
    entries_[at] = {coord, number + 1};
  }

  std::optional<std::uint32_t> find(const Coord& coord) const {
    if (entries_.empty()) return std::nullopt;
    for (std::size_t at = CoordHash{}(coord)&mask_;; at = (at + 1) & mask_) {
      const Entry& entry = entries_[at];
      if (entry.next == 0) return std::nullopt;
      if (entry.coord == coord) return entry.next - 1;
    }
  }

 private:
  struct Entry {
    Coord coord;
    std::uint32_t next = 0;  // one more than the number; 0 if the entry is empty
  };
  std::vector<Entry> entries_;
  std::size_t mask_ = 0;
};

}  // namespace t4d::voxel4d
