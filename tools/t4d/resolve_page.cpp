#include "tools/t4d/resolve_page.h"

#include <memory>

#include <fmt/format.h>

#include "measure/triangle_tree.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using model::Point3;
using model::TriangleMesh;

std::string plotsOfResolved(const formats::Metadata& metadata, const edit::ResolveReport& report) {
  const std::string time = labelled("time", metadata.timeUnit);
  Plot displacement{labelled("Largest displacement", metadata.lengthUnit),
                    time,
                    {},
                    {{"displacement", "d", {}}},
                    {0.0}};
  Plot volume{labelled("Volume", metadata.lengthUnit, "³"),
              time,
              {},
              {{"before", "a", {}}, {"after", "b", {}}}};
  for (const edit::ResolvedLayer& layer : report.layers) {
    displacement.x.push_back(layer.time);
    displacement.curves[0].values.push_back(layer.displacement);
    volume.x.push_back(layer.time);
    volume.curves[0].values.push_back(layer.volumeBefore);
    volume.curves[1].values.push_back(layer.volumeAfter);
  }
  return plotsOf({displacement, volume});
}

/// Colours a point by the nearer of two surfaces.
ColourAt coloursOf(const TriangleMesh& obstacles, const TriangleMesh& body) {
  const auto ofObstacles = std::make_shared<measure::TriangleTree>(obstacles);
  const auto ofBody = std::make_shared<measure::TriangleTree>(body);
  return [ofObstacles, ofBody](const Point3& point) {
    return ofObstacles->nearest(point).distance < ofBody->nearest(point).distance ? kGrey : kBlue;
  };
}

/// The farther the surface has moved from where it was, the redder.
ColourAt byMove(const TriangleMesh& before, double farthest) {
  const auto tree = std::make_shared<measure::TriangleTree>(before);
  return [tree, farthest](const Point3& point) {
    return blended(kBlue, kRed, farthest > 0 ? tree->nearest(point).distance / farthest : 0);
  };
}

std::string picturesOfResolved(const formats::Metadata& metadata, const ResolvedView& body) {
  if (body.obstacles.triangles.empty() || body.before.triangles.empty()) return "";
  model::Bounds3 bounds = boundsOf(body.before);
  bounds.add(boundsOf(body.after));
  const View view = viewOf(bounds, metadata.up == "z");
  const std::string when = ", t = " + withUnit(body.report.maxDisplacementTime, metadata.timeUnit);
  TriangleMesh both = body.obstacles;
  append(both, body.after);
  return figuresOf(figureOf(body.before, always(kBlue), view, body.name + " alone before" + when) +
                   figureOf(body.after, byMove(body.before, body.report.maxDisplacement), view,
                            body.name + " alone after, red where it has moved" + when) +
                   figureOf(both, coloursOf(body.obstacles, body.after), view,
                            body.name + " and the obstacles after" + when));
}

}  // namespace

std::string resolvePage(const std::string& title, const formats::Metadata& metadata,
                        const std::vector<ResolvedView>& bodies) {
  std::string html;
  for (const ResolvedView& body : bodies) {
    html += headingOf(body.name);
    const edit::ResolveReport& report = body.report;
    if (!report.changed) {
      html += paragraphOf("Clear already: nothing has moved.");
      continue;
    }
    html += paragraphOf(fmt::format(
                "Moves by at most {:.6g}, at time {:.6g}. {} of layers have moved; the hypervolume "
                "has changed by {:.6g}.",
                report.maxDisplacement, report.maxDisplacementTime,
                counted(report.movedVertices, "vertex", "vertices"), report.hypervolumeChange)) +
            plotsOfResolved(metadata, report) + picturesOfResolved(metadata, body);
  }
  return htmlPage(title, html);
}

}  // namespace t4d::tools
