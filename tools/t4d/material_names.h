#pragma once

#include <string>
#include <vector>

#include "formats/t4d/metadata.h"

namespace t4d::tools {

/// The names that the attribute `material` of a .t4d file numbers: `details.materials` of its
/// metadata. Empty if there are none.
std::vector<std::string> materialNamesOf(const formats::Metadata& metadata);

}  // namespace t4d::tools
