#pragma once

#include <string>
#include <vector>

#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/surface.h"

namespace t4d::tools {

/// A body that has given way, at the time when it has moved farthest.
struct ResolvedView {
  std::string name;
  edit::ResolveReport report;
  model::TriangleMesh obstacles;
  model::TriangleMesh before;
  model::TriangleMesh after;
};

/// One self-contained HTML page: for each body plots of its displacement and its volume over time,
/// and pictures of it and the obstacles before and after.
std::string resolvePage(const std::string& title, const formats::Metadata& metadata,
                        const std::vector<ResolvedView>& bodies);

}  // namespace t4d::tools
