#include "tools/program/compare_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "t4d/measure/distance_quantile.h"
#include "t4d/measure/triangle_tree.h"
#include "tools/program/console.h"
#include "tools/report/convergence_plot.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

using measure::SliceComparison;
using model::TriangleMesh;

constexpr Colour kColourA = {0.55F, 0.71F, 0.90F};
constexpr Colour kColourB = {0.95F, 0.72F, 0.50F};
/// From near to far: dark blue, green, yellow, in steps of equal brightness that print well.
constexpr std::array<Colour, 5> kRamp = {{{0.27F, 0.20F, 0.55F},
                                          {0.19F, 0.45F, 0.62F},
                                          {0.13F, 0.65F, 0.55F},
                                          {0.55F, 0.82F, 0.32F},
                                          {0.99F, 0.91F, 0.22F}}};
constexpr std::uint32_t kPixels = 400;
/// The colours end at the distance that this fraction of every surface stays within.
constexpr double kColoured = 0.99;

constexpr std::string_view kStyle = R"(
.slices td:first-child, .slices th:first-child { text-align: right; }
.meshes th:nth-child(2) { color: var(--a); } .meshes th:nth-child(3) { color: var(--b); }
.note { color: var(--ink); border-left: 3px solid var(--b); padding-left: 10px; }
.order { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.convergence { max-width: 460px; }
.convergence svg { width: 100%; background: var(--card); border-radius: 8px; }
.curve.true { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.dot.true { fill: none; }
.pair { display: grid; grid-template-columns: repeat(4, 1fr); gap: 16px; margin: 0 0 16px; }
figure { margin: 0; background: var(--card); border-radius: 8px; padding: 10px 12px 12px; }
figure img { width: 100%; height: auto; display: block; }
figcaption { font-size: 13px; color: var(--soft); }
@media (max-width: 900px) { .pair { grid-template-columns: repeat(2, 1fr); } }
.ramp { display: flex; align-items: center; gap: 8px; font-size: 13px; color: var(--soft);
  margin: 0 0 12px; }
.ramp i { width: 220px; height: 12px; border-radius: 3px; }
)";

Colour rampAt(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kRamp.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  const auto part = static_cast<float>(at - static_cast<double>(below));
  Colour colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    colour[c] = kRamp[below][c] + part * (kRamp[below + 1][c] - kRamp[below][c]);
  }
  return colour;
}

ColourAt always(const Colour& colour) {
  return [colour](const model::Point3&) { return colour; };
}

/// The colour of a point by its distance from a mesh that is not empty.
ColourAt byDistanceFrom(const TriangleMesh& mesh, double farthest) {
  const auto tree = std::make_shared<measure::TriangleTree>(mesh);
  return [tree, farthest](const model::Point3& point) {
    return rampAt(farthest > 0 ? tree->nearest(point).distance / farthest : 0);
  };
}

std::string unitText(const std::string& unit, std::string_view power = {}) {
  return unit.empty() ? std::string() : fmt::format(" [{}{}]", unit, power);
}

/// A mesh in a legend: its name if that is short enough.
std::string shortName(const ComparedMesh& mesh, const char* letter) {
  constexpr std::size_t kShort = 16;
  const std::string name = mesh.name.substr(0, mesh.name.find(','));
  return name.size() <= kShort ? fmt::format("{}: {}", letter, name) : letter;
}

std::string plotsOf(const CompareReport& report, const Comparison& comparison) {
  Plot volume{"Volume" + unitText(report.lengthUnit, "³"),
              "time" + unitText(report.timeUnit),
              {},
              {{shortName(comparison.a, "a"), "a", {}}, {shortName(comparison.b, "b"), "b", {}}},
              false};
  Plot area = volume;
  area.title = "Area" + unitText(report.lengthUnit, "²");
  Plot difference = volume;
  difference.title = "Symmetric difference" + unitText(report.lengthUnit, "³");
  difference.curves = {{"symmetric difference", "d", {}}};
  difference.fromZero = true;
  Plot distance = difference;
  distance.title = "Hausdorff distance" + unitText(report.lengthUnit);
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
                       "voxel size" + unitText(report.lengthUnit),
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

std::string rampOf(const CompareReport& report, double end, double farthest) {
  const std::string unit = report.lengthUnit.empty() ? "" : " " + escaped(report.lengthUnit);
  std::string stops;
  for (const Colour& colour : kRamp) {
    stops += fmt::format(", rgb({:.0f} {:.0f} {:.0f})", 255 * colour[0], 255 * colour[1],
                         255 * colour[2]);
  }
  return fmt::format(
      "<div class=\"ramp\">distance: 0 <i style=\"background: linear-gradient(90deg{})\"></i> "
      "{:.3g}{} and more: {:g} % of each surface is nearer, the farthest point at {:.3g}{}</div>\n",
      stops, end, unit, 100 * kColoured, farthest, unit);
}

std::string picturesOf(const CompareReport& report, const Comparison& comparison) {
  // All pictures share one scale of lengths and of colours, so that they can be compared.
  double extent = 0;
  std::vector<View> views;
  for (const SolidPair& pair : report.pairs) {
    model::Bounds3 bounds;
    for (const TriangleMesh* mesh : {&pair.a, &pair.b}) {
      for (const model::Point3& vertex : mesh->vertices) bounds.add(vertex);
    }
    views.push_back(viewOf(bounds, report.zUp));
    if (!bounds.empty()) extent = std::max(extent, views.back().extent);
  }
  bool edges = true;
  double coloured = 0;
  for (std::size_t i = 0; i < report.pairs.size(); ++i) {
    const auto& [time, a, b] = report.pairs[i];
    if (extent > 0) views[i].extent = extent;
    edges = edges && showsEdges(a, views[i], kPixels) && showsEdges(b, views[i], kPixels);
    coloured = std::max({coloured, measure::distanceQuantile(a, b, kColoured),
                         measure::distanceQuantile(b, a, kColoured)});
  }
  const double farthest = comparison.largestHausdorff();
  if (coloured == 0) coloured = farthest;

  std::string html = rampOf(report, coloured, farthest);
  for (std::size_t i = 0; i < report.pairs.size(); ++i) {
    const SolidPair& pair = report.pairs[i];
    const std::string& nameA = comparison.a.name;
    const std::string& nameB = comparison.b.name;
    const auto picture = [&](const TriangleMesh& mesh, const ColourAt& colourAt, Shading shading,
                             const std::string& caption) {
      html +=
          figureOf(pictureOf(mesh, colourAt, views[i], kPixels, shading, edges), kPixels, caption);
    };
    const auto plain = [&](const std::string& name, const TriangleMesh& mesh,
                           const Colour& colour) {
      picture(mesh, always(colour), Shading::Solid,
              fmt::format("{}, t = {:.6g}{}: {} triangles", name, pair.time,
                          report.timeUnit.empty() ? "" : " " + report.timeUnit,
                          grouped(mesh.triangles.size())));
    };
    html += "<div class=\"pair\">\n";
    plain("a: " + nameA, pair.a, kColourA);
    plain("b: " + nameB, pair.b, kColourB);
    if (!pair.a.triangles.empty() && !pair.b.triangles.empty()) {
      picture(pair.a, byDistanceFrom(pair.b, coloured), Shading::Faint,
              "a: " + nameA + ", by its distance from b");
      picture(pair.b, byDistanceFrom(pair.a, coloured), Shading::Faint,
              "b: " + nameB + ", by its distance from a");
    }
    html += "</div>\n";
  }
  return html;
}

std::string tableOf(const Table& table, const char* cssClass) {
  std::string html = fmt::format("<div class=\"scroll\"><table class=\"{}\">\n", cssClass);
  for (const std::vector<std::string>& row : table) {
    const char* tag = &row == &table.front() ? "th" : "td";
    html += "<tr>";
    for (const std::string& cell : row) html += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string convergenceOf(const CompareReport& report) {
  return "<h2>Convergence</h2>\n" + tableOf(convergenceTable(report), "") +
         "<p>Errors of the <span class=\"key b\">hypervolume</span>, against the true solid, and "
         "of the <span class=\"key d\">symmetric difference</span> from the mesh method, as a "
         "fraction of its volume, over the voxel size. Both axes are logarithmic; the dashed "
         "lines are of order 2. An order is the slope of the least-squares line. What follows is "
         "for the smallest voxels.</p>\n" +
         convergencePlotOf(report);
}

}  // namespace

std::string comparePage(const CompareReport& report) {
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
          "</div>\n<h2>The solids</h2>\n" + picturesOf(report, comparison);
  html +=
      "<h2>In numbers</h2>\n<p>The symmetric difference is the volume that lies in one solid and "
      "not in the other; the Hausdorff distance is how far the farthest point of one surface is "
      "from the other.</p>\n";
  html += tableOf(sliceTable(report, comparison), "slices");
  return htmlPage(report.title, kStyle, html);
}

}  // namespace t4d::tools
