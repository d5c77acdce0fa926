#include "tools/report/convergence_plot.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tools/report/svg_canvas.h"

namespace t4d::tools {
namespace {

constexpr SvgCanvas::Size kSize = {340, 300, 62, 34};
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

std::string svgOf(const ConvergencePlot& plot) {
  const Range x = rangeOf(plot.sizes);
  const Range y = rangeOf(plot.errors);
  std::vector<double> sizes;
  for (const ErrorCurve& curve : plot.curves) {
    for (const auto& point : curve.points) sizes.push_back(point.first);
  }
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  SvgCanvas canvas(kSize, plot.title);
  const auto xOf = [&](double size) {
    const double fraction = (std::log10(size) - x.low) / (x.high - x.low);
    return canvas.left() + fraction * (canvas.right() - canvas.left());
  };
  const auto yOf = [&](double error) {
    const double fraction = (std::log10(error) - y.low) / (y.high - y.low);
    return canvas.bottom() - fraction * (canvas.bottom() - canvas.top());
  };

  for (int power = static_cast<int>(std::floor(y.low)); power <= static_cast<int>(y.high) + 1;
       ++power) {
    for (const int digit : {1, 2, 5}) {
      const double error = digit * std::pow(10, power);
      if (std::log10(error) < y.low || std::log10(error) > y.high) continue;
      canvas.addRow(yOf(error), fmt::format("{:g} %", 100 * error));
    }
  }
  for (const double size : sizes) canvas.addColumn(xOf(size), fmt::format("{:g}", size), true);
  canvas.addAxisName(plot.xLabel);
  for (const ErrorCurve& curve : plot.curves) {
    if (curve.points.empty()) continue;
    const auto& [size0, error0] = curve.points.front();
    const double size1 = curve.points.back().first;
    const auto onLine = [&, size = size0, error = error0](double at) {
      return error * std::pow(at / size, plot.order);
    };
    // To the smallest size, or to where the line leaves the plot.
    const double lowest = size0 * std::pow(std::pow(10, y.low) / error0, 1 / plot.order);
    const double end = size1 < size0 ? std::max(size1, lowest) : size1;
    canvas.addLine("order", xOf(size0), yOf(error0), xOf(end), yOf(onLine(end)));
    std::vector<SvgCanvas::Point> points;
    for (const auto& [size, error] : curve.points) {
      points.push_back({xOf(size), yOf(error),
                        fmt::format("{}: {:.4g} % at {:g}", curve.name, 100 * error, size)});
    }
    canvas.addCurve(curve.cssClass, points);
  }
  return canvas.finish();
}

}  // namespace t4d::tools
