#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "t4d/frames.h"
#include "t4d/mesh.h"

namespace t4d::voxel4d {

/// A field is divided along x between blocks of 8 planes: parts share no leaf node of the grid.
constexpr std::uint64_t mostFieldParts(std::uint64_t planes) { return (planes + 7) / 8; }

/// The planes that a part has.
inline model::PartRange planesOf(const model::Part& part, std::uint64_t planes) {
  const model::PartRange blocks = part.of(mostFieldParts(planes));
  return {std::min(8 * blocks.begin, planes), std::min(8 * blocks.end, planes)};
}

/// The part of a field that a file has.
struct PointFieldPart {
  model::Part part = {};
  /// Names and values that all parts of a run share and that tell it from others.
  std::map<std::string, std::string> run = {};
};

/// A field at the points of a lattice with indices from 0 on, of those points that have a value.
struct PointField {
  std::string name = {};  ///< of the grid
  Lattice lattice = {};
  std::array<std::uint32_t, 3> counts = {0, 0, 0};  ///< also for a part those of the whole
  std::optional<PointFieldPart> part = {};          ///< nothing for the whole field
  /// Sets the value of a point; returns false if it has none. Called by one thread.
  std::function<bool(const std::array<std::uint32_t, 3>&, double&)> value;
  bool whole = false;  ///< int32 values instead of float32
};

/// Writes a .vdb file with one grid, whose active values are those of the field and whose
/// background is 0. A part has the points of its planes, and metadata for joinPointFields. Returns
/// the bytes of the file.
Result<std::uint64_t> writePointField(const std::filesystem::path& path, const PointField& field);

}  // namespace t4d::voxel4d
