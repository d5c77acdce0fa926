#pragma once

#include <string>
#include <utility>
#include <vector>

#include "t4d/model/triangle_mesh.h"

namespace t4d::tools {

/// What the page of an envelope shows.
struct EnvelopePage {
  std::string title;
  std::vector<std::pair<std::string, std::string>> numbers;  ///< names and values
  /// Captions and solids, shown at the same scale.
  std::vector<std::pair<std::string, model::TriangleMesh>> solids;
  bool zUp = false;
};

/// A self-contained HTML page with pictures and a table.
std::string envelopePage(const EnvelopePage& report);

}  // namespace t4d::tools
