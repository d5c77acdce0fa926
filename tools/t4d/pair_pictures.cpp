#include "tools/t4d/pair_pictures.h"

#include <algorithm>
#include <array>
#include <memory>

#include <fmt/format.h>

#include "measure/distance_quantile.h"
#include "measure/triangle_tree.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using model::TriangleMesh;

/// The colours from near to far: dark blue, green, yellow, in steps of equal brightness that print
/// well.
constexpr std::array<Colour, 5> kRamp = {{{0.27F, 0.20F, 0.55F},
                                          {0.19F, 0.45F, 0.62F},
                                          {0.13F, 0.65F, 0.55F},
                                          {0.55F, 0.82F, 0.32F},
                                          {0.99F, 0.91F, 0.22F}}};
/// The colours end at the distance that this fraction of every surface stays within.
constexpr double kColoured = 0.99;

Colour rampAt(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kRamp.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  return blended(kRamp[below], kRamp[below + 1], at - static_cast<double>(below));
}

/// The colour of a point by its distance from a mesh that is not empty.
ColourAt byDistanceFrom(const TriangleMesh& mesh, double farthest) {
  const auto tree = std::make_shared<measure::TriangleTree>(mesh);
  return [tree, farthest](const model::Point3& point) {
    return rampAt(farthest > 0 ? tree->nearest(point).distance / farthest : 0);
  };
}

std::string rampOf(const std::string& lengthUnit, double end, double farthest) {
  const auto length = [&](double value) {
    return fmt::format("{:.3g}{}{}", value, lengthUnit.empty() ? "" : " ", escaped(lengthUnit));
  };
  std::string stops;
  for (const Colour& colour : kRamp) {
    stops += fmt::format(", rgb({:.0f} {:.0f} {:.0f})", 255 * colour[0], 255 * colour[1],
                         255 * colour[2]);
  }
  return fmt::format(
      "<p>distance: 0 <span style=\"display: inline-block; width: 220px; height: 12px; "
      "background: linear-gradient(90deg{})\"></span> {} and more: {:g} % of each surface is "
      "nearer, the farthest point at {}</p>\n",
      stops, length(end), 100 * kColoured, length(farthest));
}

}  // namespace

std::string pairPictures(const PairCaptions& captions, const formats::Metadata& metadata,
                         std::span<const SolidPair> pairs) {
  double extent = 0;
  double coloured = 0;
  std::vector<View> views;
  for (const auto& [time, a, b] : pairs) {
    model::Bounds3 bounds = boundsOf(a);
    bounds.add(boundsOf(b));
    views.push_back(viewOf(bounds, metadata.up == "z"));
    if (!bounds.empty()) extent = std::max(extent, views.back().extent);
    coloured = std::max({coloured, measure::distanceQuantile(a, b, kColoured),
                         measure::distanceQuantile(b, a, kColoured)});
  }
  if (coloured == 0) coloured = captions.farthest;

  std::string html = rampOf(metadata.lengthUnit, coloured, captions.farthest);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [time, a, b] = pairs[i];
    View& view = views[i];
    if (extent > 0) view.extent = extent;
    const auto plain = [&](const std::string& name, const TriangleMesh& mesh,
                           const Colour& colour) {
      return figureOf(
          mesh, always(colour), view,
          fmt::format("{}, t = {}: {} triangles", name, withUnit(pairs[i].time, metadata.timeUnit),
                      grouped(mesh.triangles.size())));
    };
    std::string figures =
        plain("a: " + captions.a, a, kBlue) + plain("b: " + captions.b, b, kOrange);
    if (!a.triangles.empty() && !b.triangles.empty()) {
      figures += figureOf(a, byDistanceFrom(b, coloured), view,
                          "a: " + captions.a + ", by its distance from b", Shading::Faint) +
                 figureOf(b, byDistanceFrom(a, coloured), view,
                          "b: " + captions.b + ", by its distance from a", Shading::Faint);
    }
    html += figuresOf(figures);
  }
  return html;
}

}  // namespace t4d::tools
