#pragma once

#include <string>
#include <vector>

#include "t4d/edit/resolve.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::tools {

/// A body that has given way, at the time when it has moved farthest.
struct ResolvedView {
  std::string name;
  edit::ResolveReport report;
  model::TriangleMesh obstacles;
  model::TriangleMesh before;
  model::TriangleMesh after;
};

struct ResolvePage {
  std::string title;
  std::string lengthUnit;  ///< "" if unknown
  std::string timeUnit;
  bool zUp = false;
  std::vector<ResolvedView> bodies;
};

/// One self-contained HTML page: for each body plots of its displacement and its volume over time,
/// and pictures of it and the obstacles before and after.
std::string resolvePage(const ResolvePage& page);

}  // namespace t4d::tools
