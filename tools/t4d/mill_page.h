#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mill/mill.h"
#include "t4d/file.h"
#include "t4d/surface.h"

namespace t4d::tools {

/// Times, and the workpiece then.
using Workpieces = std::vector<std::pair<double, model::TriangleMesh>>;

/// One self-contained HTML page: the numbers, the removed volume over time, and pictures.
std::string millPage(const std::string& title, const formats::Metadata& metadata,
                     const mill::MillReport& report, const Workpieces& workpieces);

}  // namespace t4d::tools
