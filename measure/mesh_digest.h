#pragma once

#include <array>
#include <cstdint>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Tells whether two meshes have the same cells, without keeping them. Depends on the coordinates
/// of the corners of each cell, to the bit but for the sign of zero, and on which way round it is;
/// not on the order of cells, vertices or corners, nor on how the mesh is divided into slabs.
struct MeshDigest {
  std::uint64_t cells = 0;
  /// The sum of 128-bit hashes of all cells. Good against chance, not against malice.
  std::array<std::uint64_t, 2> sum{};

  friend bool operator==(const MeshDigest&, const MeshDigest&) = default;
};

class MeshDigester : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override;
  const MeshDigest& digest() const { return digest_; }

 private:
  MeshDigest digest_;
};

}  // namespace t4d::measure
