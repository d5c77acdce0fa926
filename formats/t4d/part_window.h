#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "formats/t4d/chunk_header.h"

namespace t4d::formats {

/// Writers remember the last connectivities up to these bytes, as they are stored, to write none of
/// them twice. One for all of them, so that a file has the same bytes in one go and joined of
/// parts.
inline constexpr std::size_t kRememberedBytes = std::size_t{4} << 20;

/// The last chunks of each type, which are those that the next chunks may name (SPEC.md, rules K6
/// and S12).
class PartWindow {
 public:
  explicit PartWindow(std::size_t bodyCount) : size_(t4d_layout::kWindowPerBody * bodyCount) {}

  /// Call in file order.
  void add(const ChunkHeader& chunk) {
    using namespace t4d_layout;
    if (chunk.type != kConnectivity && chunk.type != kLayer && chunk.type != kPose) return;
    std::deque<ChunkHeader>& last = last_[chunk.type];
    last.push_back(chunk);
    if (last.size() > size_) last.pop_front();
  }
  /// The chunk at `offset`; null if it is none of them.
  const ChunkHeader* find(t4d_layout::ChunkType type, std::uint64_t offset) const {
    const auto last = last_.find(type);
    if (last == last_.end()) return nullptr;
    const auto found = std::ranges::lower_bound(last->second, offset, {}, &ChunkHeader::offset);
    return found != last->second.end() && found->offset == offset ? &*found : nullptr;
  }
  /// A layer or a pose.
  const ChunkHeader* findLayer(std::uint64_t offset) const {
    const ChunkHeader* layer = find(t4d_layout::kLayer, offset);
    return layer != nullptr ? layer : find(t4d_layout::kPose, offset);
  }
  std::size_t size() const { return size_; }
  /// All chunks in the window.
  std::vector<ChunkHeader> chunks() const {
    std::vector<ChunkHeader> all;
    for (const auto& [type, last] : last_) all.insert(all.end(), last.begin(), last.end());
    return all;
  }

 private:
  std::size_t size_;
  std::map<t4d_layout::ChunkType, std::deque<ChunkHeader>> last_;
};

}  // namespace t4d::formats
