#include "formats/gltf/gltf_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

/// More numbers than this, or than the file has bytes, count as an attack.
constexpr std::size_t kMostInstanced = std::size_t{1} << 26;

}  // namespace

int gltfTargetCount(const tinygltf::Model& model, int mesh) {
  const auto* found = elementAt(model.meshes, mesh);
  std::size_t count = 0;
  if (found == nullptr) return 0;
  for (const auto& primitive : found->primitives) {
    count = std::max(count, primitive.targets.size());
  }
  return static_cast<int>(count);
}

Result<void> checkGltfCost(const InputFile& file, const tinygltf::Model& model,
                           std::span<const GltfCopies> copies) {
  std::size_t bufferBytes = 0;
  for (const auto& buffer : model.buffers) bufferBytes += buffer.data.size();
  const auto numbersOf = [&](int accessor) -> std::size_t {
    const auto* found = elementAt(model.accessors, accessor);
    // A count beyond the buffers is another error, found later.
    return found == nullptr ? 0 : std::min(found->count, bufferBytes);
  };
  const auto costOf = [&](const tinygltf::Mesh& mesh) {
    constexpr std::size_t kTransform = 12;
    std::size_t cost = kTransform;
    for (const auto& primitive : mesh.primitives) {
      cost += kTransform + numbersOf(primitive.indices);
      const auto position = primitive.attributes.find("POSITION");
      if (position != primitive.attributes.end()) cost += 3 * numbersOf(position->second);
    }
    return cost;
  };
  std::map<int, std::size_t> costs;
  std::size_t budget = std::max(kMostInstanced, file.bytes.size() + bufferBytes);
  for (const auto& [index, count] : copies) {
    const auto* mesh = elementAt(model.meshes, index);
    if (mesh == nullptr) continue;
    const auto [cost, added] = costs.try_emplace(index, 0);
    if (added) cost->second = costOf(*mesh);
    if (count > budget / cost->second) {
      return fail(ErrorCode::Unsupported,
                  "its nodes instantiate more geometry than the file holds; merge them into "
                  "one mesh",
                  gltfElement(file, "meshes", index));
    }
    budget -= count * cost->second;
  }
  return {};
}

GltfGeometry::GltfGeometry(const InputFile& file, const tinygltf::Model& model)
    : file_(file),
      model_(model),
      builder_(file.path.string(), [this](auto place) { return places_[place]; }) {}

Result<void> GltfGeometry::addMesh(int index, const Eigen::Affine3d& world) {
  const auto* mesh = elementAt(model_.meshes, index);
  if (mesh == nullptr) {
    return invalid(fmt::format("does not exist; there are {}", model_.meshes.size()),
                   gltfElement(file_, "meshes", index));
  }
  const auto [first, added] = placesOf_.try_emplace(index, places_.size());
  for (std::size_t i = 0; i < mesh->primitives.size(); ++i) {
    if (added) {
      places_.push_back(gltfElement(file_, "meshes", index, fmt::format(".primitives[{}]", i)));
    }
    place_ = first->second + i;
    if (auto done = readPrimitive(mesh->primitives[i], world); !done) return done;
  }
  return {};
}

Result<void> GltfGeometry::readPrimitive(const tinygltf::Primitive& primitive,
                                         const Eigen::Affine3d& world) {
  const int mode = primitive.mode;
  if (mode >= TINYGLTF_MODE_POINTS && mode <= TINYGLTF_MODE_LINE_STRIP) return {};
  if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
      mode != TINYGLTF_MODE_TRIANGLE_FAN) {
    return invalid(fmt::format("mode {}, expected 0 to 6", mode), places_[place_]);
  }
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return {};  // allowed, and draws nothing

  const std::uint64_t first = builder_.pointCount();
  const auto count = addPoints(position->second, world);
  if (!count) return count.error();
  builder_.setPart(static_cast<std::uint32_t>(parts_.size()));
  parts_.push_back({&primitive, *count, world.linear()});
  const auto corners = cornersOf(primitive, *count);
  if (!corners) return corners.error();
  return addTriangles(mode, *corners, first, world.linear().determinant() < 0);
}

Result<std::size_t> GltfGeometry::addPoints(int accessor, const Eigen::Affine3d& world) {
  const auto numbers = readGltfAccessor(file_, model_, accessor, 3);
  if (!numbers) return numbers.error();
  for (std::size_t i = 0; i < numbers->size(); i += 3) {
    const Eigen::Map<const Eigen::Vector3d> point(numbers->data() + i);
    if (auto added = builder_.addPoint(world * point, place_); !added) {
      return added.error();
    }
  }
  return numbers->size() / 3;
}

Result<std::vector<std::uint64_t>> GltfGeometry::cornersOf(const tinygltf::Primitive& primitive,
                                                           std::size_t pointCount) {
  std::vector<std::uint64_t> corners;
  if (primitive.indices < 0) {
    for (std::size_t i = 0; i < pointCount; ++i) corners.push_back(i);
    return corners;
  }
  const auto numbers = readGltfAccessor(file_, model_, primitive.indices, 1);
  if (!numbers) return numbers.error();
  corners.reserve(numbers->size());
  for (const double number : *numbers) {
    const auto corner = static_cast<std::uint64_t>(std::max(number, 0.0));
    if (static_cast<double>(corner) != number || corner >= pointCount) {
      return invalid(fmt::format("index {} is {}, but {} has {} positions", corners.size(), number,
                                 places_[place_].text(), pointCount),
                     gltfElement(file_, "accessors", primitive.indices));
    }
    corners.push_back(corner);
  }
  return corners;
}

/// The order of corners in strips and fans is that of the glTF 2.0 specification, 3.7.2.1. A
/// mirroring transform reverses the triangles.
Result<void> GltfGeometry::addTriangles(int mode, const std::vector<std::uint64_t>& corners,
                                        std::uint64_t first, bool mirrored) {
  const bool separate = mode == TINYGLTF_MODE_TRIANGLES;
  if (separate && corners.size() % 3 != 0) {
    return invalid(fmt::format("{} corners of triangles, expected a multiple of 3", corners.size()),
                   places_[place_]);
  }
  for (std::size_t i = 0; i + 2 < corners.size(); i += separate ? 3 : 1) {
    std::array<std::size_t, 3> at{i, i + 1, i + 2};
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) at = {i, i + 1 + i % 2, i + 2 - i % 2};
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN) at = {i + 1, i + 2, 0};
    if (mirrored) std::swap(at[1], at[2]);
    const std::array<std::uint64_t, 3> triangle{first + corners[at[0]], first + corners[at[1]],
                                                first + corners[at[2]]};
    if (auto added = builder_.addPolygon(triangle, place_); !added) return added;
  }
  return {};
}

}  // namespace t4d::formats
