#include "measure/mesh_digest.h"

#include <algorithm>
#include <bit>

namespace t4d::measure {
namespace {

using Hash = std::array<std::uint64_t, 2>;

/// A bijection in which each bit of the input changes about half of those of the output (the
/// finaliser of SplitMix64).
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ x >> 30U) * 0xBF58476D1CE4E5B9U;
  x = (x ^ x >> 27U) * 0x94D049BB133111EBU;
  return x ^ x >> 31U;
}

void absorb(Hash& hash, std::uint64_t word) {
  hash[0] = mixed(hash[0] + word + 0x9E3779B97F4A7C15U);
  hash[1] = mixed(hash[1] ^ (word * 0xD6E8FEB86659FD93U + hash[0]));
}

Hash hashOf(const model::Point4& vertex) {
  Hash hash{};
  for (const double coordinate : vertex)
    absorb(hash, std::bit_cast<std::uint64_t>(coordinate + 0.0));
  return hash;
}

}  // namespace

Result<void> MeshDigester::put(const model::Slab& slab) {
  std::vector<Hash> ofVertex;
  ofVertex.reserve(slab.vertices.size());
  for (const model::Point4& vertex : slab.vertices) ofVertex.push_back(hashOf(vertex));
  for (const model::Cell& cell : slab.connectivity->cells) {
    std::array<Hash, 4> corners{};
    for (int i = 0; i < 4; ++i) corners[i] = ofVertex[cell[i]];
    // Sorting the corners by their hashes is an even or an odd permutation.
    std::uint64_t isOdd = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) isOdd ^= corners[j] < corners[i] ? 1U : 0U;
    }
    std::ranges::sort(corners);
    Hash hash{};
    for (const Hash& corner : corners) {
      absorb(hash, corner[0]);
      absorb(hash, corner[1]);
    }
    absorb(hash, isOdd);
    digest_.sum[0] += hash[0];
    digest_.sum[1] += hash[1];
    ++digest_.cells;
  }
  return {};
}

}  // namespace t4d::measure
