#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

/// Consecutive slabs that are simplified to one.
struct Window {
  std::size_t begin = 0;
  std::size_t end = 0;  ///< one more than the last
};

/// Divides all slabs into windows of `slabs` slabs, or without that of as many as have `mostCells`
/// cells. A slab without thickness, such as a cap, is a window of its own. Reads slabs only if
/// needed to count cells.
Result<std::vector<Window>> windowsOf(const model::Source& source,
                                      std::optional<std::uint64_t> slabs, std::uint64_t mostCells);

/// The windows of a part; parts have about the same number of slabs. Fails (Options) if there are
/// fewer windows than parts.
Result<std::vector<Window>> windowsOfPart(const std::vector<Window>& windows,
                                          const model::Part& part);

}  // namespace t4d::edit
