#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "t4d/formats/t4d/layout.h"

namespace t4d::formats {

/// The offsets of the last chunks of each type, which are those that the next chunks may name
/// (SPEC.md, rules K6 and S12).
class PartWindow {
 public:
  explicit PartWindow(std::size_t bodyCount) : size_(t4d_layout::kWindowPerBody * bodyCount) {}

  /// Call in file order.
  void add(t4d_layout::ChunkType type, std::uint64_t offset) {
    using namespace t4d_layout;
    if (type != kConnectivity && type != kLayer && type != kPose) return;
    std::deque<std::uint64_t>& last = last_[type];
    last.push_back(offset);
    if (last.size() > size_) last.pop_front();
  }
  bool has(t4d_layout::ChunkType type, std::uint64_t offset) const {
    const auto last = last_.find(type);
    return last != last_.end() && std::ranges::binary_search(last->second, offset);
  }
  std::size_t size() const { return size_; }
  /// All of them.
  std::vector<std::uint64_t> offsets() const {
    std::vector<std::uint64_t> all;
    for (const auto& [type, last] : last_) all.insert(all.end(), last.begin(), last.end());
    return all;
  }

 private:
  std::size_t size_;
  std::map<t4d_layout::ChunkType, std::deque<std::uint64_t>> last_;
};

}  // namespace t4d::formats
