#include "tools/program/pair_pictures.h"

#include <algorithm>
#include <array>
#include <memory>

#include <fmt/format.h>

#include "t4d/measure/distance_quantile.h"
#include "t4d/measure/triangle_tree.h"
#include "tools/program/console.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"

namespace t4d::tools {
namespace {

using model::TriangleMesh;

constexpr Colour kColourA = {0.55F, 0.71F, 0.90F};
constexpr Colour kColourB = {0.95F, 0.72F, 0.50F};
/// From near to far: dark blue, green, yellow, in steps of equal brightness that print well.
constexpr std::array<Colour, 5> kRamp = {{{0.27F, 0.20F, 0.55F},
                                          {0.19F, 0.45F, 0.62F},
                                          {0.13F, 0.65F, 0.55F},
                                          {0.55F, 0.82F, 0.32F},
                                          {0.99F, 0.91F, 0.22F}}};
constexpr std::uint32_t kPairPixels = 400;
/// The colours end at the distance that this fraction of every surface stays within.
constexpr double kColoured = 0.99;

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

std::string rampOf(const std::string& lengthUnit, double end, double farthest) {
  const std::string unit = lengthUnit.empty() ? "" : " " + escaped(lengthUnit);
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

}  // namespace

const std::string_view kPairStyle = R"(
.pair { display: grid; grid-template-columns: repeat(4, 1fr); gap: 16px; margin: 0 0 16px; }
@media (max-width: 900px) { .pair { grid-template-columns: repeat(2, 1fr); } }
.ramp { display: flex; align-items: center; gap: 8px; font-size: 13px; color: var(--soft);
  margin: 0 0 12px; }
.ramp i { width: 220px; height: 12px; border-radius: 3px; }
)";

std::string pairPictures(const PairCaptions& captions, std::span<const SolidPair> pairs) {
  double extent = 0;
  std::vector<View> views;
  for (const SolidPair& pair : pairs) {
    model::Bounds3 bounds;
    for (const TriangleMesh* mesh : {&pair.a, &pair.b}) {
      for (const model::Point3& vertex : mesh->vertices) bounds.add(vertex);
    }
    views.push_back(viewOf(bounds, captions.zUp));
    if (!bounds.empty()) extent = std::max(extent, views.back().extent);
  }
  bool edges = true;
  double coloured = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [time, a, b] = pairs[i];
    if (extent > 0) views[i].extent = extent;
    edges = edges && showsEdges(a, views[i], kPairPixels) && showsEdges(b, views[i], kPairPixels);
    coloured = std::max({coloured, measure::distanceQuantile(a, b, kColoured),
                         measure::distanceQuantile(b, a, kColoured)});
  }
  if (coloured == 0) coloured = captions.farthest;

  std::string html = rampOf(captions.lengthUnit, coloured, captions.farthest);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const SolidPair& pair = pairs[i];
    const auto picture = [&](const TriangleMesh& mesh, const ColourAt& colourAt, Shading shading,
                             const std::string& caption) {
      html += figureOf(pictureOf(mesh, colourAt, views[i], kPairPixels, shading, edges),
                       kPairPixels, caption);
    };
    const auto plain = [&](const std::string& name, const TriangleMesh& mesh,
                           const Colour& colour) {
      picture(mesh, always(colour), Shading::Solid,
              fmt::format("{}, t = {:.6g}{}: {} triangles", name, pair.time,
                          captions.timeUnit.empty() ? "" : " " + captions.timeUnit,
                          grouped(mesh.triangles.size())));
    };
    html += "<div class=\"pair\">\n";
    plain("a: " + captions.a, pair.a, kColourA);
    plain("b: " + captions.b, pair.b, kColourB);
    if (!pair.a.triangles.empty() && !pair.b.triangles.empty()) {
      picture(pair.a, byDistanceFrom(pair.b, coloured), Shading::Faint,
              "a: " + captions.a + ", by its distance from b");
      picture(pair.b, byDistanceFrom(pair.a, coloured), Shading::Faint,
              "b: " + captions.b + ", by its distance from a");
    }
    html += "</div>\n";
  }
  return html;
}

}  // namespace t4d::tools
