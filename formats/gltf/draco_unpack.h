#pragma once

#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "t4d/error.h"

namespace t4d::formats {

/// An attribute of a compressed mesh, and the numbers that are made of it, as of an accessor.
struct DracoAttribute {
  std::uint32_t id = 0;  ///< that is unique in the mesh
  int componentType = 0;
  std::uint64_t components = 0;

  friend bool operator<(const DracoAttribute& a, const DracoAttribute& b) {
    return std::tie(a.id, a.componentType, a.components) <
           std::tie(b.id, b.componentType, b.components);
  }
};

/// A mesh that Draco has compressed, and what to take of it.
struct DracoMesh {
  std::span<const unsigned char> bytes;
  std::uint64_t pointCount = 0;  ///< that it must have
  std::vector<DracoAttribute> attributes;
};

/// True in a build that reads KHR_draco_mesh_compression.
bool hasDraco();

/// The values of the attributes, one attribute after another, `pointCount` elements each; then the
/// corners of the triangles, as 32-bit indices of points. Draco works in a process of its own, with
/// limits of time and memory. Fails, naming no place, on damaged bytes, on other counts and types
/// than those asked for, and in a build without Draco.
Result<std::vector<unsigned char>> dracoUnpacked(const DracoMesh& mesh);

}  // namespace t4d::formats
