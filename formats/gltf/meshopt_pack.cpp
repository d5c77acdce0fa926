#include "formats/gltf/meshopt_pack.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>
#include <meshoptimizer.h>

#include "t4d/surface.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kMostElementBytes = 256;

/// No packed bytes stand for more than so many times their number: at best, two bits hold a byte of
/// 16 elements, and in version 1 two bits one of 256.
constexpr std::size_t kMostRatio = 64;
constexpr std::size_t kMostRatioOf1 = 1024;

bool fitsMode(const MeshoptView& view) {
  if (view.mode == "ATTRIBUTES") {
    return view.byteStride > 0 && view.byteStride <= kMostElementBytes && view.byteStride % 4 == 0;
  }
  const bool isIndex = view.byteStride == 2 || view.byteStride == 4;
  if (view.mode == "TRIANGLES") return isIndex && view.count % 3 == 0;
  return view.mode == "INDICES" && isIndex;
}

/// Elements that the filter may be applied to.
bool fitsFilter(const MeshoptView& view) {
  if (view.filter == "NONE") return true;
  if (view.mode != "ATTRIBUTES") return false;
  if (view.filter == "OCTAHEDRAL") return view.byteStride == 4 || view.byteStride == 8;
  if (view.filter == "QUATERNION") return view.byteStride == 8;
  return view.filter == "EXPONENTIAL";
}

bool unpack(std::span<const unsigned char> packed, const MeshoptView& view,
            std::vector<unsigned char>& bytes) {
  if (view.mode == "TRIANGLES") {
    return meshopt_decodeIndexBuffer(bytes.data(), view.count, view.byteStride, packed.data(),
                                     packed.size()) == 0;
  }
  if (view.mode == "INDICES") {
    return meshopt_decodeIndexSequence(bytes.data(), view.count, view.byteStride, packed.data(),
                                       packed.size()) == 0;
  }
  return meshopt_decodeVertexBuffer(bytes.data(), view.count, view.byteStride, packed.data(),
                                    packed.size()) == 0;
}

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

Result<std::vector<unsigned char>> meshoptUnpacked(std::span<const unsigned char> packed,
                                                   const MeshoptView& view) {
  const auto& [count, stride, mode, filter] = view;
  if (!fitsMode(view) || !fitsFilter(view)) {
    return fail(ErrorCode::Unsupported, fmt::format("{} elements of {} bytes with mode {} and "
                                                    "filter {} are not supported",
                                                    count, stride, mode, filter));
  }
  const std::size_t version = packed.empty() ? 0 : packed.front() & 0xFU;
  // A division, because products of numbers from a file may overflow.
  if (count / (version == 0 ? kMostRatio : kMostRatioOf1) > packed.size() / stride) {
    return invalid(
        fmt::format("{} bytes cannot hold {} elements of {} bytes", packed.size(), count, stride));
  }
  std::vector<unsigned char> bytes(count * stride);
  if (!unpack(packed, view, bytes)) {
    return invalid(
        fmt::format("its {} bytes are damaged, or of a version later than this build's "
                    "meshoptimizer reads",
                    packed.size()));
  }
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), count, stride);
  return bytes;
}

}  // namespace t4d::formats
