#include "tools/t4d/quality_page.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "measure/triangle_tree.h"
#include "tools/report/html_page.h"
#include "tools/report/solid_picture.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using measure::Distribution;

constexpr std::size_t kBars = 60;
/// The share of the cells over the value of a measure, in bars of equal width on a logarithmic axis
/// or, for angles, a linear one. What lies beyond 99.9 % is not shown, nor, on a logarithmic axis,
/// what is 0 or infinite.
Plot histogramOf(const std::string& name, const Distribution& sides, const Distribution& caps) {
  const bool isAngle = name.ends_with("angle");
  Distribution all = sides;
  all.add(caps);
  if (!isAngle) all = all.positiveAndFinite();
  constexpr double kCut = 0.001;
  const auto axis = [&](double value) { return isAngle ? value : std::log10(value); };
  double low = axis(std::max(all.quantile(kCut), 1e-300));
  double high = axis(std::min(std::max(all.quantile(1 - kCut), 1e-300), 1e300));
  if (!(high - low > 1e-6 * std::abs(high))) {
    low -= 0.5;
    high += 0.5;
  }
  std::vector<double> edges;
  for (std::size_t i = 0; i <= kBars; ++i) {
    const double at = low + (high - low) * static_cast<double>(i) / kBars;
    edges.push_back(isAngle ? at : std::pow(10, at));
  }
  std::string title = name;
  std::ranges::replace(title, '_', ' ');
  Plot plot{"Cells by " + title + " [%]",
            isAngle ? title + " [degrees]" : "log10 of " + title,
            {},
            {{"slabs that last", "a", {}}, {"caps", "b", {}}},
            {0.0}};
  const std::vector<std::uint64_t> ofSides = sides.histogram(edges);
  const std::vector<std::uint64_t> ofCaps = caps.histogram(edges);
  for (std::size_t i = 0; i < kBars; ++i) {
    const auto share = [](std::uint64_t some, std::uint64_t of) {
      return of == 0 ? 0 : 100 * static_cast<double>(some) / static_cast<double>(of);
    };
    plot.x.push_back(low + (high - low) * (static_cast<double>(i) + 0.5) / kBars);
    plot.curves[0].values.push_back(share(ofSides[i], sides.count()));
    plot.curves[1].values.push_back(share(ofCaps[i], caps.count()));
  }
  return plot;
}

/// Red for the radius ratios of the worst cells, by their logarithm.
ColourAt byRadiusRatio(const model::TriangleMesh& solid, double worst) {
  std::vector<float> ratios(solid.triangles.size(), 1);
  for (const model::Attribute& attribute : solid.attributes) {
    if (attribute.name != "radius_ratio" || attribute.domain != model::Domain::Cell) continue;
    std::memcpy(ratios.data(), attribute.values.data(),
                std::min(attribute.values.size(), ratios.size() * sizeof(float)));
  }
  const auto tree = std::make_shared<measure::TriangleTree>(solid);
  return [tree, ratios = std::move(ratios), worst](const model::Point3& point) {
    const double ratio = ratios[tree->nearest(point).triangle];
    return blended(kBlue, kRed, worst > 1 ? std::log(ratio) / std::log(worst) : 0);
  };
}

}  // namespace

std::string qualityPage(const QualityPage& page, const formats::Metadata& metadata,
                        const measure::MeshQuality& quality) {
  std::string html = paragraphOf(page.scale) + tableOf(page.table) + headingOf("Histograms");
  if (quality.flat > 0) {
    html += paragraphOf(counted(quality.flat, "cell") +
                        " without volume: not shown where a measure is 0 or infinite.");
  }
  std::vector<Plot> plots;
  for (std::size_t k = 0; k < measure::kQualityMeasures.size(); ++k) {
    plots.push_back(histogramOf(std::string(measure::kQualityMeasures[k].name), quality.sides[k],
                                quality.caps[k]));
  }
  html += plotsOf(plots) + headingOf("The worst places");
  const double worst =
      std::min(quality.worst.empty() ? 1 : quality.worst[0].quality.radiusRatio, 1e300);
  std::string pictures;
  for (const auto& [time, place, solid] : page.views) {
    if (solid.triangles.empty()) continue;
    pictures += figureOf(
        solid, byRadiusRatio(solid, worst), viewOf(boundsOf(solid), metadata.up == "z"),
        fmt::format("t = {}, red where cells have large radius ratios; the worst is at ({:.4g}, "
                    "{:.4g}, {:.4g})",
                    withUnit(time, metadata.timeUnit), place[0], place[1], place[2]),
        Shading::Faint);
  }
  return htmlPage(page.title, html + figuresOf(pictures));
}

}  // namespace t4d::tools
