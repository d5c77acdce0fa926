#include "voxel4d/pattern_table.h"

namespace t4d::voxel4d {
namespace {

#include "voxel4d/pattern_numbers.inc"

}  // namespace

std::span<const PatternTable::Tetrahedron> PatternTable::tetrahedra(unsigned pattern) {
  return {kTetrahedra + kFirst[pattern], kTetrahedra + kFirst[pattern + 1]};
}

std::uint32_t PatternTable::count(unsigned pattern) {
  return kFirst[pattern + 1] - kFirst[pattern];
}

}  // namespace t4d::voxel4d
