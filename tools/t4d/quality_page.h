#pragma once

#include <string>
#include <vector>

#include "t4d/check.h"
#include "t4d/file.h"
#include "t4d/surface.h"
#include "tools/report/html_page.h"

namespace t4d::tools {

/// The solid at the time of a bad cell; its triangles have the attribute "radius_ratio" (float32).
struct QualityView {
  double time = 0;
  model::Point3 place = model::Point3::Zero();  ///< of the bad cell
  model::TriangleMesh solid;
};

struct QualityPage {
  std::string title;
  std::string scale;  ///< what one unit of time counts as, and why
  Table table;
  std::vector<QualityView> views;
};

/// One self-contained HTML page: the table, a histogram of each measure, and pictures of the solid
/// at the times of the worst cells, coloured by radius ratio.
std::string qualityPage(const QualityPage& page, const formats::Metadata& metadata,
                        const measure::MeshQuality& quality);

}  // namespace t4d::tools
