#include "tools/program/envelope_page.h"

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"

namespace t4d::tools {

std::string envelopePage(const EnvelopePage& report) {
  constexpr std::uint32_t kWidth = 480;
  constexpr Colour kEnvelope = {0.95F, 0.72F, 0.50F};
  constexpr Colour kSolid = {0.55F, 0.71F, 0.90F};
  model::Bounds3 bounds;
  for (const auto& [caption, mesh] : report.solids) {
    for (const model::Point3& vertex : mesh.vertices) bounds.add(vertex);
  }
  std::string html = "<div class=\"solids\">\n";
  const View view = viewOf(bounds, report.zUp);
  for (std::size_t i = 0; i < report.solids.size(); ++i) {
    const auto& [caption, mesh] = report.solids[i];
    const Colour& colour = i == 0 ? kEnvelope : kSolid;
    const auto png = pictureOf(
        mesh, [&](const model::Point3&) { return colour; }, view, kWidth, Shading::Solid,
        showsEdges(mesh, view, kWidth));
    html += figureOf(png, kWidth, caption);
  }
  html += "</div>\n<table>\n";
  for (const auto& [name, value] : report.numbers) {
    html += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escaped(name), escaped(value));
  }
  html += "</table>\n";
  return htmlPage(report.title,
                  ".solids { display: grid; grid-template-columns: repeat(2, 1fr); gap: 16px; }\n",
                  html);
}

}  // namespace t4d::tools
