#include "tools/t4d/simplify_page.h"

#include <filesystem>

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/console.h"
#include "tools/t4d/pair_pictures.h"

namespace t4d::tools {
namespace {

Table numbersOf(const SimplifyReport& report) {
  const edit::SimplifyReport& mesh = report.mesh;
  return {{"", "before", "after"},
          {"cells", grouped(mesh.cellsBefore), grouped(mesh.cells)},
          {"vertices", grouped(mesh.verticesBefore), grouped(mesh.vertices)},
          {"hypervolume", fmt::format("{:.12g}", mesh.hypervolumeBefore),
           fmt::format("{:.12g}", mesh.hypervolume)},
          {"size", sizeText(report.bytesBefore), sizeText(report.bytes)}};
}

/// What 1, 50 and 99 per cent of the cells do not exceed.
Table shapesOf(const SimplifyReport& report) {
  Table rows = {
      {"of cells", "1 % before", "after", "50 % before", "after", "99 % before", "after"}};
  for (std::size_t k = 0; k < measure::kQualityMeasures.size(); ++k) {
    const std::array cells = {report.quality[0].all(k), report.quality[1].all(k)};
    auto& row = rows.emplace_back();
    row.emplace_back(measure::kQualityMeasures[k].name);
    for (const double fraction : {0.01, 0.5, 0.99}) {
      for (const auto& one : cells) row.push_back(fmt::format("{:.4g}", one.quantile(fraction)));
    }
  }
  return rows;
}

Plot plotOf(const SimplifyReport& report, const formats::Metadata& metadata) {
  Plot plot{labelled("Distance of slices", metadata.lengthUnit),
            labelled("time", metadata.timeUnit),
            {},
            {{"measured", "d", {}}},
            {0.0}};
  for (const auto& [time, distance] : report.distances) {
    plot.x.push_back(time);
    plot.curves[0].values.push_back(distance);
  }
  if (report.mesh.maxError) {
    plot.curves.push_back(
        {"proved", "a", std::vector<double>(plot.x.size(), *report.mesh.maxError)});
  }
  return plot;
}

}  // namespace

std::string simplifyPage(const std::string& input, const std::string& output,
                         const formats::Metadata& metadata, const SimplifyReport& report) {
  const std::string before = std::filesystem::path(input).filename().string();
  const std::string after = std::filesystem::path(output).filename().string();
  std::vector<SolidPair> pairs;
  for (const auto& [time, a, b] : report.pairs) pairs.push_back({time, a, b});
  return htmlPage(before + ", simplified",
                  tableOf(numbersOf(report)) + tableOf(shapesOf(report)) + headingOf("Over time") +
                      plotsOf({plotOf(report, metadata)}) + headingOf("The solids") +
                      pairPictures({before, after, report.measuredError}, metadata, pairs));
}

}  // namespace t4d::tools
