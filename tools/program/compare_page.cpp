#include "tools/program/compare_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "t4d/measure/triangle_tree.h"
#include "tools/program/console.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

using measure::SliceComparison;
using model::TriangleMesh;

constexpr Colour kColourA = {0.55F, 0.71F, 0.90F};
constexpr Colour kColourB = {0.95F, 0.72F, 0.50F};
/// Near to far, as evenly bright steps as can be told apart in print: dark blue, green, yellow.
constexpr std::array<Colour, 5> kRamp = {{{0.27F, 0.20F, 0.55F},
                                          {0.19F, 0.45F, 0.62F},
                                          {0.13F, 0.65F, 0.55F},
                                          {0.55F, 0.82F, 0.32F},
                                          {0.99F, 0.91F, 0.22F}}};
constexpr std::uint32_t kPixels = 400;

constexpr std::string_view kStyle = R"(
.slices td:first-child, .slices th:first-child { text-align: right; }
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

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      group = group << 8 | (i + j < bytes.size() ? bytes[i + j] : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j <= bytes.size() ? kDigits[group >> (18 - 6 * j) & 63U] : '=';
    }
  }
  return text;
}

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

/// The colour of a point by its distance from a mesh, which is not empty.
ColourAt byDistanceFrom(const TriangleMesh& mesh, double farthest) {
  const auto tree = std::make_shared<measure::TriangleTree>(mesh);
  return [tree, farthest](const model::Point3& point) {
    return rampAt(farthest > 0 ? tree->nearest(point).distance / farthest : 0);
  };
}

std::string unitText(const std::string& unit, std::string_view power = {}) {
  return unit.empty() ? std::string() : fmt::format(" [{}{}]", unit, power);
}

std::string plotsOf(const Comparison& comparison) {
  Plot volume{"Volume" + unitText(comparison.lengthUnit, "³"),
              "time" + unitText(comparison.timeUnit),
              {},
              {{"a", "a", {}}, {"b", "b", {}}},
              false};
  Plot area = volume;
  area.title = "Area" + unitText(comparison.lengthUnit, "²");
  Plot difference = volume;
  difference.title = "Symmetric difference" + unitText(comparison.lengthUnit, "³");
  difference.curves = {{"symmetric difference", "d", {}}};
  difference.fromZero = true;
  Plot distance = difference;
  distance.title = "Hausdorff distance" + unitText(comparison.lengthUnit);
  distance.curves = {{"Hausdorff distance", "d", {}}};
  if (comparison.volumeExpected) {
    volume.curves.insert(volume.curves.begin(), {"true volume", "true",
                                                 std::vector<double>(comparison.slices.size(),
                                                                     *comparison.volumeExpected)});
  }
  const std::size_t first = volume.curves.size() - 2;
  for (const SliceComparison& slice : comparison.slices) {
    for (Plot* plot : {&volume, &area, &difference, &distance}) plot->x.push_back(slice.time);
    volume.curves[first].values.push_back(slice.volumeA);
    volume.curves[first + 1].values.push_back(slice.volumeB);
    area.curves[0].values.push_back(slice.areaA);
    area.curves[1].values.push_back(slice.areaB);
    difference.curves[0].values.push_back(slice.difference.volume);
    distance.curves[0].values.push_back(slice.distance.hausdorff());
  }
  return svgOf(volume) + svgOf(area) + svgOf(difference) + svgOf(distance);
}

std::string figure(std::span<const std::uint8_t> png, const std::string& caption) {
  return fmt::format(
      "<figure><img alt=\"{0}\" width=\"{1}\" height=\"{1}\" src=\"data:image/png;base64,{2}\">"
      "<figcaption>{0}</figcaption></figure>\n",
      escaped(caption), kPixels, base64(png));
}

std::string picturesOf(const Comparison& comparison, const std::vector<SolidPair>& pairs,
                       bool zUp) {
  // One scale for all, of lengths and of colours, so that pictures can be compared.
  double extent = 0;
  std::vector<View> views;
  for (const SolidPair& pair : pairs) {
    model::Bounds3 bounds;
    for (const TriangleMesh* mesh : {&pair.a, &pair.b}) {
      for (const model::Point3& vertex : mesh->vertices) bounds.add(vertex);
    }
    views.push_back(viewOf(bounds, zUp));
    if (!bounds.empty()) extent = std::max(extent, views.back().extent);
  }
  double farthest = 0;
  for (const SliceComparison& slice : comparison.slices) {
    const double distance = slice.distance.hausdorff();
    if (std::isfinite(distance)) farthest = std::max(farthest, distance);
  }

  std::string stops;
  for (const Colour& colour : kRamp) {
    stops += fmt::format(", rgb({:.0f} {:.0f} {:.0f})", 255 * colour[0], 255 * colour[1],
                         255 * colour[2]);
  }
  std::string html = fmt::format(
      "<div class=\"ramp\">distance: 0 <i style=\"background: "
      "linear-gradient(90deg{})\"></i> {:.4g}{}</div>\n",
      stops, farthest, comparison.lengthUnit.empty() ? "" : " " + escaped(comparison.lengthUnit));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const SolidPair& pair = pairs[i];
    if (extent > 0) views[i].extent = extent;
    html += "<div class=\"pair\">\n";
    const auto plain = [&](std::string_view name, const TriangleMesh& mesh, const Colour& colour) {
      return figure(pictureOf(mesh, always(colour), views[i], kPixels),
                    fmt::format("{}, t = {:.6g}: {} triangles", name, pair.time,
                                grouped(mesh.triangles.size())));
    };
    html += plain("a", pair.a, kColourA) + plain("b", pair.b, kColourB);
    if (!pair.a.triangles.empty() && !pair.b.triangles.empty()) {
      html += figure(
          pictureOf(pair.a, byDistanceFrom(pair.b, farthest), views[i], kPixels, Shading::Faint),
          "a: distance from b");
      html += figure(
          pictureOf(pair.b, byDistanceFrom(pair.a, farthest), views[i], kPixels, Shading::Faint),
          "b: distance from a");
    }
    html += "</div>\n";
  }
  return html;
}

std::string numberText(double value) { return fmt::format("{:.9g}", value); }

}  // namespace

std::optional<double> ComparedMesh::hypervolumeError() const {
  if (!hypervolumeExpected || *hypervolumeExpected == 0) return std::nullopt;
  return hypervolume / *hypervolumeExpected - 1;
}

std::vector<CompareRow> compareRows(const Comparison& comparison) {
  const ComparedMesh& a = comparison.a;
  const ComparedMesh& b = comparison.b;
  const auto ratio = [](double ofA, double ofB) {
    return ofA > 0 ? fmt::format("{:.3g}", ofB / ofA) : std::string();
  };
  std::vector<CompareRow> rows;
  const auto orUnknown = [](const std::string& text) { return text.empty() ? "-" : text; };
  if (!a.name.empty()) rows.push_back({"file", a.name, b.name, ""});
  rows.push_back({"backend", orUnknown(a.backend), orUnknown(b.backend), ""});
  const auto count = [&](const char* label, std::uint64_t ofA, std::uint64_t ofB) {
    rows.push_back({label, grouped(ofA), grouped(ofB),
                    ratio(static_cast<double>(ofA), static_cast<double>(ofB))});
  };
  count("vertices", a.vertices, b.vertices);
  count("tetrahedra", a.tetrahedra, b.tetrahedra);
  rows.push_back({"size of the file", sizeText(a.bytes), sizeText(b.bytes),
                  ratio(static_cast<double>(a.bytes), static_cast<double>(b.bytes))});
  if (a.seconds && b.seconds) {
    rows.push_back({"construction", fmt::format("{:.3f} s", *a.seconds),
                    fmt::format("{:.3f} s", *b.seconds), ratio(*a.seconds, *b.seconds)});
  }
  if (a.peakBytes && b.peakBytes) {
    rows.push_back({"peak memory", sizeText(*a.peakBytes), sizeText(*b.peakBytes),
                    ratio(static_cast<double>(*a.peakBytes), static_cast<double>(*b.peakBytes))});
  }
  rows.push_back({"hypervolume", numberText(a.hypervolume), numberText(b.hypervolume),
                  ratio(a.hypervolume, b.hypervolume)});
  if (a.hypervolumeExpected && b.hypervolumeExpected) {
    rows.push_back({"  of the true solid", numberText(*a.hypervolumeExpected),
                    numberText(*b.hypervolumeExpected), ""});
  }
  if (a.hypervolumeError() && b.hypervolumeError()) {
    const auto percent = [](double fraction) {
      return std::abs(fraction) < 1e-12 ? "0 %" : fmt::format("{:+.3g} %", 100 * fraction);
    };
    rows.push_back({"  error", percent(*a.hypervolumeError()), percent(*b.hypervolumeError()), ""});
  }
  return rows;
}

std::vector<std::string> sliceColumns() {
  return {"time",   "volume a",        "volume b", "area a",
          "area b", "sym. difference", "of a",     "Hausdorff"};
}

std::vector<std::string> sliceRow(const SliceComparison& slice) {
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  const double volume = slice.difference.volume;
  return {number(slice.time),
          number(slice.volumeA),
          number(slice.volumeB),
          number(slice.areaA),
          number(slice.areaB),
          number(volume),
          slice.volumeA > 0 ? fmt::format("{:.3g} %", 100 * volume / slice.volumeA) : "-",
          std::isfinite(slice.distance.hausdorff()) ? number(slice.distance.hausdorff()) : "-"};
}

std::string comparePage(const Comparison& comparison, const std::vector<SolidPair>& pairs,
                        bool zUp) {
  std::string html =
      "<p>Two 4D meshes: <span class=\"key a\">a</span> and <span class=\"key b\">b</span>.</p>\n";
  auto out = std::back_inserter(html);
  html +=
      "<div class=\"scroll\"><table>\n<tr><th></th><th><span class=\"key a\">a</span></th>"
      "<th><span class=\"key b\">b</span></th><th>b / a</th></tr>\n";
  for (const CompareRow& row : compareRows(comparison)) {
    fmt::format_to(out, "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                   escaped(row.label), escaped(row.a), escaped(row.b), escaped(row.ratio));
  }
  html += "</table></div>\n<h2>Over time</h2>\n<div class=\"plots\">\n";
  html += plotsOf(comparison);
  html += "</div>\n<h2>The solids</h2>\n";
  html += picturesOf(comparison, pairs, zUp);
  html +=
      "<h2>In numbers</h2>\n<p>The symmetric difference is the volume of what lies in one solid "
      "and not in the other; the Hausdorff distance is how far the farthest point of one surface "
      "is from the other.</p>\n<div class=\"scroll\"><table class=\"slices\">\n<tr>";
  for (const std::string& column : sliceColumns()) {
    fmt::format_to(out, "<th>{}</th>", escaped(column));
  }
  html += "</tr>\n";
  for (const SliceComparison& slice : comparison.slices) {
    html += "<tr>";
    for (const std::string& cell : sliceRow(slice)) {
      fmt::format_to(out, "<td>{}</td>", escaped(cell));
    }
    html += "</tr>\n";
  }
  html += "</table></div>\n";
  return htmlPage(comparison.title, kStyle, html);
}

}  // namespace t4d::tools
