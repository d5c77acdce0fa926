#pragma once

#include <cstdint>

#include <nlohmann/json_fwd.hpp>

#include "tools/t4d/input.h"

namespace t4d::tools {

/// The members that all parts of a run on these meshes have in common, with the number of times if
/// any. For meshes in memory, only the number of slabs.
nlohmann::ordered_json identityOf(const Input& input, std::uint64_t times = 0);

}  // namespace t4d::tools
