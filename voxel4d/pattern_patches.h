#pragma once

#include <cstdint>
#include <vector>

#include "voxel4d/pattern_table.h"

/// The numbers of PatternTable, which are computed when the library is built.
namespace t4d::voxel4d {

struct PatternPatches {
  /// The tetrahedra of pattern p are those from first[p] to first[p + 1].
  std::vector<std::uint32_t> first;
  std::vector<PatternTable::Tetrahedron> tetrahedra;
  /// The number of classes of patterns up to symmetries of the hypercube.
  int classCount = 0;
};

/// Computes the patches by exact integer arithmetic.
PatternPatches computePatternPatches();

}  // namespace t4d::voxel4d
