#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "t4d/model/part.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

/// Consecutive slabs that become one.
struct Window {
  std::size_t begin = 0;
  std::size_t end = 0;  ///< one more than the last
};

/// All slabs in windows of so many, or of as many as have some hundred thousand cells; each slab
/// without thickness, as caps are, is alone. Reads slabs only if they must be to count cells.
Result<std::vector<Window>> windowsOf(const model::Source& source,
                                      std::optional<std::uint64_t> slabs);

/// Those of a part; parts have about the same number of slabs. Fails (Options) if there are fewer
/// windows than parts.
Result<std::vector<Window>> windowsOfPart(const std::vector<Window>& windows,
                                          const model::Part& part);

}  // namespace t4d::edit
