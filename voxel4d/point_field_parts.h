#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "t4d/error.h"

namespace t4d::voxel4d {

struct JoinedField {
  std::string name;                ///< of the grid
  std::uint64_t activePoints = 0;  ///< points that have a value
  std::uint64_t bytes = 0;         ///< of the file
};

/// Joins the parts of a field (PointField::part), in any order, to the file that writePointField
/// makes of the whole: the same bytes. Takes the memory of the leaf nodes of the whole field.
///
/// Fails if a file is not part of a field, or is damaged (its UUID covers every byte); if the
/// parts are of different fields, lattices or runs, or one is missing or given twice.
Result<JoinedField> joinPointFields(std::span<const std::filesystem::path> parts,
                                    const std::filesystem::path& path);

}  // namespace t4d::voxel4d
