#include "tools/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tools/report/svg_canvas.h"

namespace t4d::tools {
namespace {

constexpr SvgCanvas::Size kPlotSize = {520, 260, 78, 34};
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

/// Formats a label with as many digits as the steps between labels need, and without an exponent
/// below a million.
std::string labelOf(double value, double step) {
  if (std::abs(value) < step / 2) return "0";
  constexpr int kWholeDigits = 6;
  const int first = static_cast<int>(std::floor(std::log10(std::max(std::abs(value), step))));
  const int digits = first - static_cast<int>(std::floor(std::log10(step))) + 2;
  return fmt::format("{:.{}g}", value, std::max(digits, first < kWholeDigits ? first + 1 : 2));
}

/// The names of the curves, each beside a piece of it, in a row below the title.
void addLegend(SvgCanvas& canvas, const std::vector<Curve>& curves) {
  double x = canvas.left();
  for (const Curve& curve : curves) {
    canvas.addLine("curve " + curve.cssClass, x, kPlotSize.top, x + kSwatch, kPlotSize.top);
    canvas.addText(x + kSwatch + 6, kPlotSize.top + 4, curve.name);
    x += kSwatch + 6 + kCharacter * static_cast<double>(curve.name.size()) + 18;
  }
}

}  // namespace

std::string labelled(const std::string& text, const std::string& unit, std::string_view power) {
  return unit.empty() ? text : fmt::format("{} [{}{}]", text, unit, power);
}

std::string svgOf(const Plot& plot) {
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
  // Draw values that are equal up to rounding as equal.
  constexpr double kEqual = 1e-9;
  if (high - low <= kEqual * std::max(std::abs(low), std::abs(high))) low = high;
  if (plot.fromZero) low = std::min(low, 0.0);
  Axis y = axisOver(low, high);
  if (plot.fromZero) y.low = 0;
  const double xBegin = plot.x.empty() ? 0 : plot.x.front();
  const double xEnd = plot.x.empty() ? 0 : plot.x.back();
  const Axis xTicks = axisOver(xBegin, xEnd);
  const double xSpan = xEnd - xBegin;

  SvgCanvas::Size size = kPlotSize;
  const bool hasLegend = plot.curves.size() > 1;
  if (hasLegend) size.top += kLegendHeight;
  SvgCanvas canvas(size, plot.title);
  if (hasLegend) addLegend(canvas, plot.curves);
  const auto xOf = [&](double value) {
    const double fraction = xSpan > 0 ? (value - xBegin) / xSpan : 0.5;
    return canvas.left() + fraction * (canvas.right() - canvas.left());
  };
  const auto yOf = [&](double value) {
    const double fraction = (value - y.low) / (y.high - y.low);
    return canvas.bottom() - fraction * (canvas.bottom() - canvas.top());
  };
  const int yCount = static_cast<int>(std::lround((y.high - y.low) / y.step));
  for (int i = 0; i <= yCount; ++i) {
    const double value = y.low + i * y.step;
    canvas.addRow(yOf(value), labelOf(value, y.step));
  }
  const int xCount = static_cast<int>(std::lround((xTicks.high - xTicks.low) / xTicks.step));
  for (int i = 0; i <= xCount; ++i) {
    const double value = xTicks.low + i * xTicks.step;
    const double slack = 1e-9 * std::max(xSpan, 1e-300);
    if (value < xBegin - slack || value > xEnd + slack) continue;
    canvas.addColumn(xOf(value), labelOf(value, xTicks.step), false);
  }
  canvas.addAxisName(plot.xLabel);
  for (const Curve& curve : plot.curves) {
    std::vector<SvgCanvas::Point> points;
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      if (!std::isfinite(curve.values[i])) continue;
      points.push_back(
          {xOf(plot.x[i]), yOf(curve.values[i]),
           fmt::format("{}: {:.9g} at {:.6g}", curve.name, curve.values[i], plot.x[i])});
    }
    canvas.addCurve(curve.cssClass, points);
  }
  return canvas.finish();
}

}  // namespace t4d::tools
