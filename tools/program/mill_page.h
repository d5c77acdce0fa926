#pragma once

#include <string>
#include <vector>

#include "t4d/mill/mill.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::tools {

/// The contents of the page.
struct MillPage {
  std::string title;
  std::string lengthUnit;  ///< "" if unknown
  std::string timeUnit;
  mill::MillReport report;
  std::vector<std::pair<double, model::TriangleMesh>> workpieces;  ///< at some times
  bool zUp = false;
};

/// One self-contained HTML page: the numbers, the removed volume over time, and pictures.
std::string millPage(const MillPage& page);

}  // namespace t4d::tools
