#include "tools/program/resolve_page.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "t4d/measure/triangle_tree.h"
#include "tools/program/console.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

using model::Point3;
using model::TriangleMesh;

constexpr Colour kObstacleColour = {0.72F, 0.74F, 0.78F};
constexpr Colour kBodyColour = {0.55F, 0.71F, 0.90F};
constexpr Colour kMovedColour = {0.90F, 0.36F, 0.20F};
constexpr std::uint32_t kResolvePixels = 480;

constexpr std::string_view kResolveStyle = R"(
.solids { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(360px, 100%), 1fr));
  gap: 16px; margin: 0 0 16px; }
)";

std::string inBrackets(const std::string& unit) {
  return unit.empty() ? std::string() : fmt::format(" [{}]", unit);
}

std::string plotsOfResolved(const ResolvePage& page, const edit::ResolveReport& report) {
  Plot displacement{"Largest displacement" + inBrackets(page.lengthUnit),
                    "time" + inBrackets(page.timeUnit),
                    {},
                    {{"displacement", "d", {}}},
                    true};
  Plot volume{"Volume" + inBrackets(page.lengthUnit.empty() ? "" : page.lengthUnit + "³"),
              "time" + inBrackets(page.timeUnit),
              {},
              {{"before", "a", {}}, {"after", "b", {}}},
              false};
  for (const edit::ResolvedLayer& layer : report.layers) {
    displacement.x.push_back(layer.time);
    displacement.curves[0].values.push_back(layer.displacement);
    volume.x.push_back(layer.time);
    volume.curves[0].values.push_back(layer.volumeBefore);
    volume.curves[1].values.push_back(layer.volumeAfter);
  }
  return "<div class=\"plots\">\n" + svgOf(displacement) + svgOf(volume) + "</div>\n";
}

/// Which of two surfaces a point is on: the nearer one.
ColourAt coloursOf(const TriangleMesh& obstacles, const TriangleMesh& body) {
  const auto ofObstacles = std::make_shared<measure::TriangleTree>(obstacles);
  const auto ofBody = std::make_shared<measure::TriangleTree>(body);
  return [ofObstacles, ofBody](const Point3& point) {
    return ofObstacles->nearest(point).distance < ofBody->nearest(point).distance ? kObstacleColour
                                                                                  : kBodyColour;
  };
}

/// The farther the surface has moved from where it was, the redder.
ColourAt byMove(const TriangleMesh& before, double farthest) {
  const auto tree = std::make_shared<measure::TriangleTree>(before);
  return [tree, farthest](const Point3& point) {
    const auto part = static_cast<float>(
        farthest > 0 ? std::min(tree->nearest(point).distance / farthest, 1.0) : 0);
    Colour colour{};
    for (std::size_t c = 0; c < 3; ++c) {
      colour[c] = kBodyColour[c] + part * (kMovedColour[c] - kBodyColour[c]);
    }
    return colour;
  };
}

std::string picturesOfResolved(const ResolvePage& page, const ResolvedView& body) {
  if (body.obstacles.triangles.empty() || body.before.triangles.empty()) return "";
  model::Bounds3 bounds = boundsOf(body.before);
  bounds.add(boundsOf(body.after));
  const View view = viewOf(bounds, page.zUp);
  std::string html;
  const auto picture = [&](const TriangleMesh& mesh, const ColourAt& colours,
                           const std::string& caption) {
    const auto png = pictureOf(mesh, colours, view, kResolvePixels, Shading::Solid,
                               showsEdges(mesh, view, kResolvePixels));
    html += figureOf(png, kResolvePixels, caption);
  };
  const std::string when = fmt::format("t = {:.6g}{}{}", body.report.maxDisplacementTime,
                                       page.timeUnit.empty() ? "" : " ", page.timeUnit);
  const ColourAt plain = [](const Point3&) { return kBodyColour; };
  picture(body.before, plain, fmt::format("{} alone before, {}", body.name, when));
  picture(body.after, byMove(body.before, body.report.maxDisplacement),
          fmt::format("{} alone after, red where it has moved, {}", body.name, when));
  TriangleMesh both = body.obstacles;
  append(both, body.after);
  picture(both, coloursOf(body.obstacles, body.after),
          fmt::format("{} and the obstacles after, {}", body.name, when));
  return "<div class=\"solids\">\n" + html + "</div>\n";
}

}  // namespace

std::string resolvePage(const ResolvePage& page) {
  std::string html;
  for (const ResolvedView& body : page.bodies) {
    html += fmt::format("<h2>{}</h2>\n", escaped(body.name));
    const edit::ResolveReport& report = body.report;
    if (!report.changed) {
      html += "<p>Clear already: nothing has moved.</p>\n";
      continue;
    }
    html += fmt::format(
        "<p>Moves by at most {:.6g}, at time {:.6g}. {} of layers have moved; the hypervolume has "
        "changed by {:.6g}.</p>\n",
        report.maxDisplacement, report.maxDisplacementTime,
        counted(report.movedVertices, "vertex", "vertices"), report.hypervolumeChange);
    html += plotsOfResolved(page, report) + picturesOfResolved(page, body);
  }
  return htmlPage(page.title, kResolveStyle, html);
}

}  // namespace t4d::tools
