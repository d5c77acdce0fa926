#include "tools/t4d/mill_page.h"

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"

namespace t4d::tools {
namespace {

Table numbersOf(const mill::MillReport& report, const formats::Metadata& metadata) {
  const auto volume = [&](double value) { return withUnit(value, metadata.lengthUnit, "³"); };
  const auto period = [&](const model::TimeSpan& time) {
    return withUnit(time.begin, metadata.timeUnit) + " to " + withUnit(time.end, metadata.timeUnit);
  };
  Table rows = {{},
                {"stock", volume(report.stockVolume)},
                {"removed", volume(report.removedVolume)},
                {"remaining", volume(report.remainingVolume)},
                {"components", fmt::format("{}", report.components)},
                {"frames", fmt::format("{}", report.progress.size())},
                {"steps of the tool", fmt::format("{}", report.steps)}};
  for (const mill::Separation& one : report.separations) {
    rows.push_back({"falls apart", fmt::format("{}, into {}", period(one.time), one.components)});
  }
  for (const mill::Collision& one : report.collisions) {
    rows.push_back({"collision of the " + mill::partOfTool(one.part, one.tool),
                    fmt::format("{}, at ({:.4g}, {:.4g}, {:.4g})", period(one.time), one.point.x(),
                                one.point.y(), one.point.z())});
  }
  return rows;
}

Plot plotOf(const mill::MillReport& report, const formats::Metadata& metadata) {
  Plot plot{labelled("Removed volume", metadata.lengthUnit, "³"),
            labelled("time", metadata.timeUnit),
            {},
            {{"removed volume", "d", {}}},
            {0.0}};
  for (const mill::MillProgress& at : report.progress) {
    plot.x.push_back(at.time);
    plot.curves[0].values.push_back(at.removedVolume);
  }
  return plot;
}

}  // namespace

std::string millPage(const std::string& title, const formats::Metadata& metadata,
                     const mill::MillReport& report, const Workpieces& workpieces) {
  model::Bounds3 bounds;
  for (const auto& [time, mesh] : workpieces) bounds.add(model::boundsOf(mesh));
  const View view = viewOf(bounds, metadata.up == "z");
  std::string pictures;
  for (const auto& [time, mesh] : workpieces) {
    pictures += figureOf(mesh, always(kBlue), view, "t = " + withUnit(time, metadata.timeUnit));
  }
  return htmlPage(title, tableOf(numbersOf(report, metadata)) + headingOf("Over time") +
                             plotsOf({plotOf(report, metadata)}) + headingOf("The workpiece") +
                             figuresOf(pictures));
}

}  // namespace t4d::tools
