#include "tools/t4d/collide_page.h"

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

/// The triangles with the flag, with the vertices of all.
model::TriangleMesh onlyFlagged(const model::TriangleMesh& mesh, const std::vector<bool>& flags) {
  model::TriangleMesh part;
  part.vertices = mesh.vertices;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (flags[i]) part.triangles.push_back(mesh.triangles[i]);
  }
  return part;
}

std::string picturesOf(const formats::Metadata& metadata, const CollidePair& pair) {
  model::Bounds3 bounds = boundsOf(pair.solidA);
  bounds.add(boundsOf(pair.solidB));
  if (bounds.empty()) return "";
  const View view = viewOf(bounds, metadata.up == "z");
  const std::string when = ", t = " + withUnit(pair.time, metadata.timeUnit);
  const auto one = [&](const model::TriangleMesh& mesh, const std::vector<bool>& contact,
                       const Colour& colour, const std::string& name) {
    const std::string html = figureOf(mesh, always(colour), view, name + when);
    const model::TriangleMesh marked = onlyFlagged(mesh, contact);
    if (marked.triangles.empty()) return html;
    return html + figureOf(marked, always(kRed), view, name + ": triangles in contact");
  };
  model::TriangleMesh both = pair.solidA;
  append(both, pair.solidB);
  return figuresOf(figureOf(both, always(kGrey), view, "both" + when) +
                   one(pair.solidA, pair.contactA, kBlue, pair.a) +
                   one(pair.solidB, pair.contactB, kOrange, pair.b));
}

std::vector<Plot> plotsOverTime(const formats::Metadata& metadata, const CollidePair& pair) {
  const std::string time = labelled("time", metadata.timeUnit);
  std::vector<Plot> plots;
  if (!pair.times.empty()) {
    plots.push_back({labelled("Clearance", metadata.lengthUnit),
                     time,
                     pair.times,
                     {{"clearance", "a", pair.clearance}},
                     {0.0}});
  }
  if (!pair.overlaps.empty()) {
    plots.push_back({labelled("Volume of the overlap", metadata.lengthUnit, "³"),
                     time,
                     pair.times,
                     {{"overlap", "d", pair.overlaps}},
                     {0.0}});
  }
  return plots;
}

}  // namespace

std::string collidePage(const std::string& title, const formats::Metadata& metadata,
                        const std::vector<CollidePair>& pairs) {
  std::string html;
  for (const CollidePair& pair : pairs) {
    html += headingOf(pair.a + " and " + pair.b) + paragraphOf(pair.verdict) +
            plotsOf(plotsOverTime(metadata, pair)) + picturesOf(metadata, pair);
  }
  html += paragraphOf(
      "The clearance is the smallest distance of the two solids at each of the times drawn; 0 "
      "means contact.");
  return htmlPage(title, html);
}

}  // namespace t4d::tools
