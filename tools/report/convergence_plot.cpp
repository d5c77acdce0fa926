#include "tools/report/convergence_plot.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

constexpr double kWidth = 340;
constexpr double kHeight = 300;
constexpr double kLeft = 62;
constexpr double kRight = 14;
constexpr double kTop = 34;
constexpr double kBottom = 40;
/// Room around the points, in decades.
constexpr double kMargin = 0.12;

struct Range {
  double low = 0;  // powers of ten
  double high = 0;
};

Range rangeOf(const std::pair<double, double>& values) {
  return {std::log10(values.first) - kMargin, std::log10(values.second) + kMargin};
}

}  // namespace

std::optional<double> orderOf(const std::vector<std::pair<double, double>>& points) {
  double x = 0;
  double y = 0;
  for (const auto& [size, error] : points) {
    x += std::log(size) / static_cast<double>(points.size());
    y += std::log(error) / static_cast<double>(points.size());
  }
  double xx = 0;
  double xy = 0;
  for (const auto& [size, error] : points) {
    xx += (std::log(size) - x) * (std::log(size) - x);
    xy += (std::log(size) - x) * (std::log(error) - y);
  }
  if (!(xx > 0)) return std::nullopt;
  return xy / xx;
}

std::string svgOf(const ConvergencePlot& plot) {
  const Range x = rangeOf(plot.sizes);
  const Range y = rangeOf(plot.errors);
  std::vector<double> sizes;
  for (const ErrorCurve& curve : plot.curves) {
    for (const auto& point : curve.points) sizes.push_back(point.first);
  }
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  const auto xOf = [&](double size) {
    return kLeft + (std::log10(size) - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight);
  };
  const auto yOf = [&](double error) {
    return kHeight - kBottom -
           (std::log10(error) - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  };

  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" aria-label=\"{2}\">\n"
      "<text class=\"title\" x=\"12\" y=\"20\">{2}</text>\n",
      kWidth, kHeight, escaped(plot.title));
  auto out = std::back_inserter(svg);
  for (int power = static_cast<int>(std::floor(y.low)); power <= static_cast<int>(y.high) + 1;
       ++power) {
    for (const int digit : {1, 2, 5}) {
      const double error = digit * std::pow(10, power);
      if (std::log10(error) < y.low || std::log10(error) > y.high) continue;
      fmt::format_to(out,
                     "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
                     "<text class=\"axis\" x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g} "
                     "%</text>\n",
                     kLeft, kWidth - kRight, yOf(error), kLeft - 8, yOf(error) + 4, 100 * error);
    }
  }
  for (const double size : sizes) {
    fmt::format_to(out,
                   "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2:.1f}\"/>"
                   "<text class=\"axis\" x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4:g}"
                   "</text>\n",
                   xOf(size), kTop, kHeight - kBottom, kHeight - kBottom + 16, size);
  }
  fmt::format_to(
      out, "<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
      (kLeft + kWidth - kRight) / 2, kHeight - 6, escaped(plot.xLabel));
  for (const ErrorCurve& curve : plot.curves) {
    if (curve.points.empty()) continue;
    const auto& [size0, error0] = curve.points.front();
    const double size1 = curve.points.back().first;
    fmt::format_to(
        out, "<line class=\"order\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n",
        xOf(size0), yOf(error0), xOf(size1), yOf(error0 * std::pow(size1 / size0, plot.order)));
    std::string points;
    for (const auto& [size, error] : curve.points) {
      points += fmt::format("{:.1f},{:.1f} ", xOf(size), yOf(error));
    }
    fmt::format_to(out, "<polyline class=\"curve {}\" points=\"{}\"/>\n", curve.cssClass, points);
    for (const auto& [size, error] : curve.points) {
      fmt::format_to(out,
                     "<circle class=\"dot {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>{}: "
                     "{:.4g} % at {:g}</title></circle>\n",
                     curve.cssClass, xOf(size), yOf(error), escaped(curve.name), 100 * error, size);
    }
  }
  return svg + "</svg>\n";
}

}  // namespace t4d::tools
