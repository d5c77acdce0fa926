#include "tools/program/collide_page.h"

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

constexpr Colour kBodyA = {0.55F, 0.71F, 0.90F};
constexpr Colour kBodyB = {0.95F, 0.72F, 0.50F};
constexpr Colour kContact = {0.80F, 0.10F, 0.15F};
constexpr std::uint32_t kSide = 480;

constexpr std::string_view kCollideStyle = R"(
.pair { display: grid; grid-template-columns: repeat(3, 1fr); gap: 16px; margin: 0 0 16px; }
@media (max-width: 900px) { .pair { grid-template-columns: 1fr; } }
)";

/// The triangles whose flag is this, with the vertices of all.
model::TriangleMesh only(const model::TriangleMesh& mesh, const std::vector<bool>& flags,
                         bool flag) {
  model::TriangleMesh part;
  part.vertices = mesh.vertices;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (flags[i] == flag) part.triangles.push_back(mesh.triangles[i]);
  }
  return part;
}

std::string imageOf(const model::TriangleMesh& mesh, const ColourAt& colour, const View& view,
                    const std::string& caption) {
  const auto png = pictureOf(mesh, colour, view, kSide, Shading::Solid, /*edges=*/false);
  return figureOf(png, kSide, caption);
}

std::string picturesOf(const CollidePage& report, const CollidePair& pair) {
  model::Bounds3 bounds = boundsOf(pair.solidA);
  bounds.add(boundsOf(pair.solidB));
  if (bounds.empty()) return "";
  const View view = viewOf(bounds, report.zUp);
  const std::string when =
      fmt::format("t = {:.6g}{}", pair.time, report.timeUnit.empty() ? "" : " " + report.timeUnit);
  const auto one = [&](const model::TriangleMesh& mesh, const std::vector<bool>& contact,
                       const Colour& colour, const std::string& name) {
    // The colour of a point is that of its triangle: those in contact are drawn a second time.
    const model::TriangleMesh marked = only(mesh, contact, true);
    const ColourAt plain = [colour](const model::Point3&) { return colour; };
    std::string html = imageOf(mesh, plain, view, name + ", " + when);
    if (marked.triangles.empty()) return html;
    const ColourAt red = [](const model::Point3&) { return kContact; };
    return html + imageOf(marked, red, view, "of " + name + ", what is in contact");
  };
  model::TriangleMesh both = pair.solidA;
  append(both, pair.solidB);
  const ColourAt grey = [](const model::Point3&) { return Colour{0.75F, 0.75F, 0.75F}; };
  return "<div class=\"pair\">\n" + imageOf(both, grey, view, "both, " + when) +
         one(pair.solidA, pair.contactA, kBodyA, pair.a) +
         one(pair.solidB, pair.contactB, kBodyB, pair.b) + "</div>\n";
}

std::string plotsOf(const CollidePage& report, const CollidePair& pair) {
  const std::string time = labelled("time", report.timeUnit);
  std::string html = "<div class=\"plots\">\n";
  if (!pair.times.empty()) {
    html += svgOf(Plot{labelled("Clearance", report.lengthUnit),
                       time,
                       pair.times,
                       {{"clearance", "a", pair.clearance}},
                       true});
  }
  if (!pair.overlaps.empty()) {
    html += svgOf(Plot{labelled("Volume of the overlap", report.lengthUnit, "³"),
                       time,
                       pair.times,
                       {{"overlap", "d", pair.overlaps}},
                       true});
  }
  return html + "</div>\n";
}

}  // namespace

std::string collidePage(const CollidePage& report) {
  std::string html;
  for (const CollidePair& pair : report.pairs) {
    html += fmt::format("<h2>{} and {}</h2>\n<p>{}</p>\n", escaped(pair.a), escaped(pair.b),
                        escaped(pair.verdict));
    html += plotsOf(report, pair) + picturesOf(report, pair);
  }
  html +=
      "<p>The clearance is the smallest distance of the two solids at each of the times drawn; 0 "
      "means contact.</p>\n";
  return htmlPage(report.title, kCollideStyle, html);
}

}  // namespace t4d::tools
