#pragma once

#include <string>
#include <vector>

#include "t4d/weave.h"

namespace t4d::tools {

class Members;

/// Adds `parts_lost`, the parts that are lost between frames.
void addLostParts(Members& members, const voxel4d::LostParts& parts);

/// Adds a notice if there are any.
void noticeLostParts(const voxel4d::LostParts& parts, std::vector<std::string>& notices);

}  // namespace t4d::tools
