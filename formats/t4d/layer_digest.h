#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::formats {

/// Tells whether two layers have the same positions, without keeping them: a CRC-32C of each
/// coordinate for each block of kBlockRows vertices. -0 counts as 0.
class LayerDigest {
 public:
  /// The digest of no vertices.
  LayerDigest() = default;
  explicit LayerDigest(std::span<const model::Point4> vertices);
  /// The digest of `count` vertices whose blocks are set later, one by one.
  explicit LayerDigest(std::uint64_t count);

  std::uint64_t size() const { return count_; }
  std::size_t blockCount() const { return blocks_.size(); }
  void setBlock(std::size_t block, std::span<const model::Point4> vertices);

  friend bool operator==(const LayerDigest&, const LayerDigest&) = default;

 private:
  std::uint64_t count_ = 0;
  std::vector<std::array<std::uint32_t, 3>> blocks_;
};

}  // namespace t4d::formats
