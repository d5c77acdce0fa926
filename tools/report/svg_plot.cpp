#include "tools/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

constexpr double kWidth = 520;
constexpr double kHeight = 260;
constexpr double kLeft = 78;
constexpr double kRight = 14;
constexpr double kTop = 34;
constexpr double kBottom = 40;
constexpr double kLegendHeight = 18;
constexpr double kSwatch = 22;
/// About the width of a character of 12 pixels.
constexpr double kCharacter = 6.6;

struct Axis {
  double low = 0;
  double high = 1;
  double step = 1;
};

/// An axis that starts and ends on a multiple of 1, 2 or 5 times a power of ten.
Axis axisOver(double low, double high) {
  if (!(high > low)) {
    const double around = std::max(std::abs(low) * 0.01, 1e-12);
    low -= around;
    high += around;
  }
  constexpr double kSteps = 5;
  const double rough = (high - low) / kSteps;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double factor = rough / power;
  const double step = power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
  return {std::floor(low / step) * step, std::ceil(high / step) * step, step};
}

/// With as many digits as the steps between labels need.
std::string labelOf(double value, double step) {
  if (std::abs(value) < step / 2) return "0";
  const double largest = std::max(std::abs(value), step);
  const int digits =
      static_cast<int>(std::floor(std::log10(largest)) - std::floor(std::log10(step))) + 2;
  return fmt::format("{:.{}g}", value, std::max(digits, 2));
}

/// The names of the curves, each beside a piece of it, in a row below the title.
std::string legendOf(const Plot& plot) {
  std::string svg;
  double x = kLeft;
  for (const Curve& curve : plot.curves) {
    svg += fmt::format(
        "<line class=\"curve {0}\" x1=\"{1:.1f}\" x2=\"{2:.1f}\" y1=\"{3}\" y2=\"{3}\"/>"
        "<text class=\"axis\" x=\"{4:.1f}\" y=\"{5}\">{6}</text>\n",
        curve.cssClass, x, x + kSwatch, kTop, x + kSwatch + 6, kTop + 4, escaped(curve.name));
    x += kSwatch + 6 + kCharacter * static_cast<double>(curve.name.size()) + 18;
  }
  return svg;
}

}  // namespace

std::string svgOf(const Plot& plot) {
  const bool hasLegend = plot.curves.size() > 1;
  const double top = kTop + (hasLegend ? kLegendHeight : 0);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Curve& curve : plot.curves) {
    for (const double value : curve.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) low = high = 0;
  // Values that are equal up to rounding are drawn as equal.
  constexpr double kEqual = 1e-9;
  if (high - low <= kEqual * std::max(std::abs(low), std::abs(high))) low = high;
  if (plot.fromZero) low = std::min(low, 0.0);
  Axis y = axisOver(low, high);
  if (plot.fromZero) y.low = 0;
  const Axis xTicks = axisOver(plot.x.front(), plot.x.back());
  const double xSpan = plot.x.back() - plot.x.front();
  const auto xOf = [&](double value) {
    const double fraction = xSpan > 0 ? (value - plot.x.front()) / xSpan : 0.5;
    return kLeft + fraction * (kWidth - kLeft - kRight);
  };
  const auto yOf = [&](double value) {
    return kHeight - kBottom - (value - y.low) / (y.high - y.low) * (kHeight - top - kBottom);
  };

  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n"
      "<text class=\"title\" x=\"{}\" y=\"18\">{}</text>\n",
      kWidth, kHeight, escaped(plot.title), kLeft, escaped(plot.title));
  if (hasLegend) svg += legendOf(plot);
  auto out = std::back_inserter(svg);
  const int yCount = static_cast<int>(std::lround((y.high - y.low) / y.step));
  for (int i = 0; i <= yCount; ++i) {
    const double value = y.low + i * y.step;
    fmt::format_to(out,
                   "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
                   "<text class=\"axis\" x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
                   kLeft, kWidth - kRight, yOf(value), kLeft - 8, yOf(value) + 4,
                   labelOf(value, y.step));
  }
  const int xCount = static_cast<int>(std::lround((xTicks.high - xTicks.low) / xTicks.step));
  for (int i = 0; i <= xCount; ++i) {
    const double value = xTicks.low + i * xTicks.step;
    const double slack = 1e-9 * std::max(xSpan, 1e-300);
    if (value < plot.x.front() - slack || value > plot.x.back() + slack) continue;
    fmt::format_to(out,
                   "<text class=\"axis\" x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                   xOf(value), kHeight - kBottom + 18, labelOf(value, xTicks.step));
  }
  fmt::format_to(out, "<text class=\"axis\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                 (kLeft + kWidth - kRight) / 2, kHeight - 6, escaped(plot.xLabel));
  for (const Curve& curve : plot.curves) {
    std::string points;
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      if (!std::isfinite(curve.values[i])) continue;
      points += fmt::format("{:.1f},{:.1f} ", xOf(plot.x[i]), yOf(curve.values[i]));
    }
    fmt::format_to(out, "<polyline class=\"curve {}\" points=\"{}\"/>\n", curve.cssClass, points);
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      if (!std::isfinite(curve.values[i])) continue;
      fmt::format_to(out,
                     "<circle class=\"dot {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>{}: "
                     "{:.9g} at {:.6g}</title></circle>\n",
                     curve.cssClass, xOf(plot.x[i]), yOf(curve.values[i]), escaped(curve.name),
                     curve.values[i], plot.x[i]);
    }
  }
  return svg + "</svg>\n";
}

}  // namespace t4d::tools
