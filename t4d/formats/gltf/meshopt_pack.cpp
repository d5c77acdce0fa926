#include "t4d/formats/gltf/meshopt_pack.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include <meshoptimizer.h>

#include "t4d/formats/triangle/triangle_mesh_writer.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kMostElementBytes = 256;

std::vector<unsigned char> packedTriangles(std::span<const unsigned char> bytes,
                                           std::size_t elementBytes) {
  std::vector<unsigned int> indices(bytes.size() / elementBytes);
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::uint16_t small = 0;
    if (elementBytes == 2) std::memcpy(&small, bytes.data() + 2 * i, 2);
    if (elementBytes == 2) indices[i] = small;
    if (elementBytes == 4) std::memcpy(&indices[i], bytes.data() + 4 * i, 4);
    vertices = std::max<std::size_t>(vertices, std::size_t{indices[i]} + 1);
  }
  // The version of the extension. It is the same for all, and so is set for the whole program.
  meshopt_encodeIndexVersion(1);
  std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.resize(
      meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

}  // namespace

bool hasMeshopt() { return true; }

std::optional<std::vector<unsigned char>> meshoptPacked(std::span<const unsigned char> bytes,
                                                        std::size_t elementBytes,
                                                        bool isTriangles) {
  if (bytes.empty()) return std::nullopt;
  if (isTriangles) return packedTriangles(bytes, elementBytes);
  if (elementBytes % 4 != 0 || elementBytes > kMostElementBytes) return std::nullopt;
  const std::size_t count = bytes.size() / elementBytes;
  meshopt_encodeVertexVersion(0);
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(count, elementBytes));
  packed.resize(
      meshopt_encodeVertexBuffer(packed.data(), packed.size(), bytes.data(), count, elementBytes));
  return packed;
}

}  // namespace t4d::formats
