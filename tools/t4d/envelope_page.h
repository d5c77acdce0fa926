#pragma once

#include <string>
#include <utility>
#include <vector>

#include "t4d/surface.h"
#include "tools/report/html_page.h"

namespace t4d::tools {

/// Captions and solids, shown at the same scale; the envelope is the first.
using CaptionedSolids = std::vector<std::pair<std::string, model::TriangleMesh>>;

/// A self-contained HTML page with pictures and a table.
std::string envelopePage(const std::string& title, const CaptionedSolids& solids, bool zUp,
                         const Table& numbers);

}  // namespace t4d::tools
