#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// A field at the points of a lattice with indices from 0 on, of those points that have a value.
struct PointField {
  std::string name = {};  ///< of the grid
  Lattice lattice = {};
  std::array<std::uint32_t, 3> counts = {0, 0, 0};
  /// Whether the point has a value, and the value. Called by one thread.
  std::function<bool(const std::array<std::uint32_t, 3>&, double&)> value;
  bool whole = false;  ///< int32 values instead of float32
};

/// Writes a .vdb file with one grid, whose active values are those of the field and whose
/// background is 0. Returns the bytes of the file.
Result<std::uint64_t> writePointField(const std::filesystem::path& path, const PointField& field);

}  // namespace t4d::voxel4d
