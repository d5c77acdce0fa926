#include "tools/program/mill_page.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

constexpr std::uint32_t kPixels = 400;

constexpr std::string_view kStyle = R"(
.workpieces { display: grid; grid-template-columns: repeat(3, 1fr); gap: 16px; margin: 0 0 16px; }
@media (max-width: 900px) { .workpieces { grid-template-columns: repeat(2, 1fr); } }
)";

std::string withUnit(const std::string& text, const std::string& unit,
                     std::string_view power = {}) {
  return unit.empty() ? text : fmt::format("{} {}{}", text, unit, power);
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escaped(name), escaped(value));
}

std::string tableOf(const MillPage& page) {
  const auto volume = [&](double value) {
    return withUnit(fmt::format("{:.6g}", value), page.lengthUnit, "³");
  };
  const auto time = [&](double value) {
    return withUnit(fmt::format("{:.6g}", value), page.timeUnit);
  };
  const mill::MillReport& report = page.report;
  std::string html = "<div class=\"scroll\"><table>\n";
  html += row("stock", volume(report.stockVolume)) + row("removed", volume(report.removedVolume)) +
          row("remaining", volume(report.remainingVolume)) +
          row("components", fmt::format("{}", report.components)) +
          row("frames", fmt::format("{}", report.progress.size())) +
          row("steps of the tool", fmt::format("{}", report.steps));
  for (const mill::Separation& one : report.separations) {
    html += row("falls apart", fmt::format("{} to {}, into {}", time(one.time.begin),
                                           time(one.time.end), one.components));
  }
  for (const mill::Collision& one : report.collisions) {
    html += row("collision of the " + mill::partOfTool(one.part, one.tool),
                fmt::format("{} to {}, at ({:.4g}, {:.4g}, {:.4g})", time(one.time.begin),
                            time(one.time.end), one.point.x(), one.point.y(), one.point.z()));
  }
  return html + "</table></div>\n";
}

std::string plotOf(const MillPage& page) {
  const std::string unit = page.lengthUnit.empty() ? "" : fmt::format(" [{}³]", page.lengthUnit);
  Plot plot{"Removed volume" + unit,
            "time" + (page.timeUnit.empty() ? "" : fmt::format(" [{}]", page.timeUnit)),
            {},
            {{"removed volume", "d", {}}},
            true};
  for (const mill::MillProgress& at : page.report.progress) {
    plot.x.push_back(at.time);
    plot.curves[0].values.push_back(at.removedVolume);
  }
  return "<div class=\"plots\">\n" + svgOf(plot) + "</div>\n";
}

std::string picturesOf(const MillPage& page) {
  // One scale, that of the stock.
  model::Bounds3 bounds;
  for (const auto& [time, mesh] : page.workpieces) bounds.add(model::boundsOf(mesh));
  const View view = viewOf(bounds, page.zUp);
  std::string html = "<div class=\"workpieces\">\n";
  for (const auto& [time, mesh] : page.workpieces) {
    const auto png = pictureOf(
        mesh,
        [](const model::Point3&) {
          return Colour{0.55F, 0.71F, 0.90F};
        },
        view, kPixels, Shading::Solid, showsEdges(mesh, view, kPixels));
    html += figureOf(png, kPixels, "t = " + withUnit(fmt::format("{:.6g}", time), page.timeUnit));
  }
  return html + "</div>\n";
}

}  // namespace

std::string millPage(const MillPage& page) {
  return htmlPage(page.title, kStyle,
                  tableOf(page) + "<h2>Over time</h2>\n" + plotOf(page) +
                      "<h2>The workpiece</h2>\n" + picturesOf(page));
}

}  // namespace t4d::tools
