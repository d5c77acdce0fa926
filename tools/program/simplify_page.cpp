#include "tools/program/simplify_page.h"

#include <filesystem>

#include <fmt/format.h>

#include "tools/program/console.h"
#include "tools/program/pair_pictures.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

std::vector<std::vector<std::string>> numbersOf(const verbs::SimplifyReport& report) {
  const edit::SimplifyReport& mesh = report.mesh;
  std::vector<std::vector<std::string>> rows = {
      {"", "before", "after"},
      {"cells", grouped(mesh.cellsBefore), grouped(mesh.cells)},
      {"vertices", grouped(mesh.verticesBefore), grouped(mesh.vertices)},
      {"hypervolume", fmt::format("{:.12g}", mesh.hypervolumeBefore),
       fmt::format("{:.12g}", mesh.hypervolume)},
      {"size", sizeText(report.bytesBefore), sizeText(report.bytes)}};
  return rows;
}

/// What 1, 50 and 99 per cent of the cells do not exceed.
std::vector<std::vector<std::string>> shapesOf(const verbs::SimplifyReport& report) {
  std::vector<std::vector<std::string>> rows = {
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

std::string plotOf(const verbs::SimplifyReport& report, const formats::Metadata& metadata) {
  Plot plot{labelled("Distance of slices", metadata.lengthUnit),
            labelled("time", metadata.timeUnit),
            {},
            {{"measured", "d", {}}},
            true};
  for (const auto& [time, distance] : report.distances) {
    plot.x.push_back(time);
    plot.curves[0].values.push_back(distance);
  }
  if (report.mesh.maxError) {
    plot.curves.push_back(
        {"proved", "a", std::vector<double>(plot.x.size(), *report.mesh.maxError)});
  }
  return svgOf(plot);
}

}  // namespace

std::string simplifyPage(const std::string& input, const std::string& output,
                         const formats::Metadata& metadata, const verbs::SimplifyReport& report) {
  const std::string before = std::filesystem::path(input).filename().string();
  const std::string after = std::filesystem::path(output).filename().string();
  std::vector<SolidPair> pairs;
  for (const auto& [time, a, b] : report.pairs) pairs.push_back({time, a, b});
  const std::string html = tableOf(numbersOf(report)) + tableOf(shapesOf(report)) +
                           "<h2>Over time</h2>\n<div class=\"plots\">\n" +
                           plotOf(report, metadata) + "</div>\n<h2>The solids</h2>\n" +
                           pairPictures({before, after, metadata.lengthUnit, metadata.timeUnit,
                                         metadata.up == "z", report.measuredError},
                                        pairs);
  return htmlPage(before + ", simplified", kPairStyle, html);
}

}  // namespace t4d::tools
