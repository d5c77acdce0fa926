#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "t4d/weave.h"

namespace t4d::verbs {

/// Parts that are lost between frames, as JSON (`parts_lost` in docs/json.md).
nlohmann::ordered_json jsonOf(const voxel4d::LostParts& parts);

/// Adds a notice if there are any.
void noticeLostParts(const voxel4d::LostParts& parts, std::vector<std::string>& notices);

}  // namespace t4d::verbs
