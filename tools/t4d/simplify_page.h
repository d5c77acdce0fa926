#pragma once

#include <string>

#include "t4d/file.h"
#include "tools/t4d/simplify.h"

namespace t4d::tools {

/// One self-contained HTML page: the numbers before and after, the distance of slices over time,
/// and slices of both beside each other.
std::string simplifyPage(const std::string& input, const std::string& output,
                         const formats::Metadata& metadata, const SimplifyReport& report);

}  // namespace t4d::tools
