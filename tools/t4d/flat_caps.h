#pragma once

#include <string>
#include <vector>

#include "t4d/weave.h"

namespace t4d::tools {

/// Adds a notice if most cells of a woven mesh are in its flat caps.
void noticeFlatCaps(voxel4d::CapStyle caps, const voxel4d::WeaveReport& report,
                    std::vector<std::string>& notices);

}  // namespace t4d::tools
