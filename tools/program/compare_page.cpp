#include "tools/program/compare_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "tools/program/console.h"
#include "tools/program/pair_pictures.h"
#include "tools/report/convergence_plot.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

using measure::SliceComparison;
using verbs::ComparedMesh;
using verbs::CompareReport;
using verbs::Comparison;

constexpr std::string_view kStyle = R"(
.slices td:first-child, .slices th:first-child { text-align: right; }
.meshes th:nth-child(2) { color: var(--a); } .meshes th:nth-child(3) { color: var(--b); }
.note { color: var(--ink); border-left: 3px solid var(--b); padding-left: 10px; }
.order { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.convergence { max-width: 460px; }
.convergence svg { width: 100%; background: var(--card); border-radius: 8px; }
.curve.true { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.dot.true { fill: none; }
)";

/// A mesh in a legend: its name if that is short enough.
std::string shortName(const ComparedMesh& mesh, const char* letter) {
  constexpr std::size_t kShort = 16;
  const std::string name = mesh.name.substr(0, mesh.name.find(','));
  return name.size() <= kShort ? fmt::format("{}: {}", letter, name) : letter;
}

std::string plotsOf(const CompareReport& report, const Comparison& comparison) {
  Plot volume{labelled("Volume", report.lengthUnit, "³"),
              labelled("time", report.timeUnit),
              {},
              {{shortName(comparison.a, "a"), "a", {}}, {shortName(comparison.b, "b"), "b", {}}},
              false};
  Plot area = volume;
  area.title = labelled("Area", report.lengthUnit, "²");
  Plot difference = volume;
  difference.title = labelled("Symmetric difference", report.lengthUnit, "³");
  difference.curves = {{"symmetric difference", "d", {}}};
  difference.fromZero = true;
  Plot distance = difference;
  distance.title = labelled("Hausdorff distance", report.lengthUnit);
  distance.curves = {{"Hausdorff distance", "d", {}}};
  if (comparison.volumeExpected) {
    volume.curves.push_back(
        {"true solid", "true",
         std::vector<double>(comparison.slices.size(), *comparison.volumeExpected)});
  }
  for (const SliceComparison& slice : comparison.slices) {
    for (Plot* plot : {&volume, &area, &difference, &distance}) plot->x.push_back(slice.time);
    volume.curves[0].values.push_back(slice.volumeA);
    volume.curves[1].values.push_back(slice.volumeB);
    area.curves[0].values.push_back(slice.areaA);
    area.curves[1].values.push_back(slice.areaB);
    difference.curves[0].values.push_back(slice.difference.volume);
    distance.curves[0].values.push_back(slice.distance.hausdorff());
  }
  return svgOf(volume) + svgOf(area) + svgOf(difference) + svgOf(distance);
}

std::string convergencePlotOf(const CompareReport& report) {
  ConvergencePlot plot{"Errors",
                       labelled("voxel size", report.lengthUnit),
                       {{"hypervolume", "b", {}}, {"symmetric difference", "d", {}}},
                       2,
                       {report.comparisons.back().b.voxelSize.value_or(1),
                        report.comparisons.front().b.voxelSize.value_or(1)},
                       {std::numeric_limits<double>::infinity(), 0}};
  const auto add = [&](ErrorCurve& curve, double size, const std::optional<double>& error) {
    constexpr double kRounding = 1e-12;
    if (!error || !(std::abs(*error) > kRounding)) return;
    curve.points.emplace_back(size, std::abs(*error));
    plot.errors.first = std::min(plot.errors.first, std::abs(*error));
    plot.errors.second = std::max(plot.errors.second, std::abs(*error));
  };
  for (const Comparison& comparison : report.comparisons) {
    if (!comparison.b.voxelSize) continue;
    add(plot.curves[0], *comparison.b.voxelSize, comparison.b.hypervolumeError());
    add(plot.curves[1], *comparison.b.voxelSize, comparison.meanDifference());
  }
  if (!(plot.errors.second > 0)) return "";
  return "<div class=\"convergence\">" + svgOf(plot) + "</div>\n";
}

std::string convergenceOf(const CompareReport& report) {
  return "<h2>Convergence</h2>\n" + tableOf(convergenceTable(report)) +
         "<p>Errors of the <span class=\"key b\">hypervolume</span>, against the true solid, and "
         "of the <span class=\"key d\">symmetric difference</span> from the mesh method, as a "
         "fraction of its volume, over the voxel size. Both axes are logarithmic; the dashed "
         "lines are of order 2. An order is the slope of the least-squares line. What follows is "
         "for the smallest voxels.</p>\n" +
         convergencePlotOf(report);
}

}  // namespace

std::string comparePage(const std::string& title, const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  std::string html = fmt::format(
      "<p><span class=\"key a\">a</span> is {}, <span class=\"key b\">b</span> is {}.</p>\n",
      escaped(comparison.a.name), escaped(comparison.b.name));
  for (const std::string& note : report.notes) {
    html += fmt::format("<p class=\"note\">Note: {}.</p>\n", escaped(note));
  }
  if (report.comparisons.size() > 1) html += convergenceOf(report) + "<h2>The meshes</h2>\n";
  html += tableOf(meshTable(report, comparison), "meshes") + "<h2>Over time</h2>\n";
  if (comparison.volumeExpected) {
    html +=
        "<p>The dashed line is the volume of the true solid, which does not change as it "
        "moves.</p>\n";
  }
  html += "<div class=\"plots\">\n" + plotsOf(report, comparison) +
          "</div>\n<h2>The solids</h2>\n" +
          pairPictures({comparison.a.name, comparison.b.name, report.lengthUnit, report.timeUnit,
                        report.zUp, comparison.largestHausdorff()},
                       report.pairs);
  html +=
      "<h2>In numbers</h2>\n<p>The symmetric difference is the volume that lies in one solid and "
      "not in the other; the Hausdorff distance is how far the farthest point of one surface is "
      "from the other.</p>\n";
  html += tableOf(sliceTable(report, comparison), "slices");
  return htmlPage(title, std::string(kStyle).append(kPairStyle), html);
}

}  // namespace t4d::tools
