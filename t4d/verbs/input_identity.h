#pragma once

#include <cstdint>

#include <nlohmann/json_fwd.hpp>

#include "t4d/verbs/input.h"

namespace t4d::verbs {

/// What is the same in all parts of a run that reads these meshes, at so many times if any. Of
/// meshes in memory, only the number of slabs.
nlohmann::ordered_json identityOf(const Input& input, std::uint64_t times = 0);

}  // namespace t4d::verbs
