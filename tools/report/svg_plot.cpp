#include "tools/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

// The picture and, within its margins, the area of the curves; pixels from the top left.
constexpr double kWidth = 520;
constexpr double kHeight = 260;
constexpr double kLeft = 78;
constexpr double kRight = 506;
constexpr double kTop = 34;
constexpr double kBottom = 220;
constexpr double kLegendHeight = 18;
constexpr double kSwatch = 22;
/// The approximate width of a character of 12 pixels.
constexpr double kCharacter = 6.6;
/// More dots would only thicken the curve.
constexpr std::size_t kMostDots = 2000;

struct Tick {
  double at;
  std::string label;
};

/// Values, or the logarithms of values, with the labels of some.
struct Axis {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::vector<Tick> ticks = {};

  void cover(double at) {
    if (!std::isfinite(at)) return;
    low = std::min(low, at);
    high = std::max(high, at);
  }
  double fraction(double at) const { return high > low ? (at - low) / (high - low) : 0.5; }
};

/// A step of 1, 2 or 5 times a power of ten, of which the axis has about five.
double stepOf(const Axis& axis) {
  constexpr double kSteps = 5;
  const double rough = (axis.high - axis.low) / kSteps;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double factor = rough / power;
  return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
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

/// Labels multiples of a step. With `extend`, the axis begins and ends at one.
void addTicks(Axis& axis, bool extend) {
  constexpr double kRounding = 1e-9;  // of a step
  if (!(axis.high > axis.low)) {
    if (!extend) {
      axis.ticks.push_back({axis.low, fmt::format("{:g}", axis.low)});
      return;
    }
    const double around = std::abs(axis.low) * 0.01;
    axis.low -= around;
    axis.high += around > 0 ? around : 1;
  }
  const double step = stepOf(axis);
  double first = std::ceil(axis.low / step - kRounding);
  double last = std::floor(axis.high / step + kRounding);
  if (extend) {
    first = std::floor(axis.low / step);
    last = std::ceil(axis.high / step);
    axis.low = first * step;
    axis.high = last * step;
  }
  const std::int64_t count = std::llround(last - first);
  for (std::int64_t i = 0; i <= count; ++i) {
    const double value = (first + static_cast<double>(i)) * step;
    axis.ticks.push_back({value, labelOf(value, step)});
  }
}

/// Labels powers of ten and, if there are few, values between them.
void addLogarithmicTicks(Axis& axis) {
  constexpr double kMargin = 0.15;  // in decades, on either side, so that there is a label
  constexpr double kFewDecades = 2;
  axis.low -= kMargin;
  axis.high += kMargin;
  const bool few = axis.high - axis.low < kFewDecades;
  for (double power = std::floor(axis.low); power <= axis.high; ++power) {
    for (const double digit : {1.0, 2.0, 3.0, 5.0}) {
      const double at = power + std::log10(digit);
      if (at < axis.low || at > axis.high || (digit > 1 && !few)) continue;
      axis.ticks.push_back({at, fmt::format("{:g}", digit * std::pow(10, power))});
    }
  }
}

std::string lineOf(std::string_view cssClass, double x1, double y1, double x2, double y2) {
  return fmt::format(
      "<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", cssClass,
      x1, y1, x2, y2);
}

std::string textAt(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format(
      "<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
      escaped(text));
}

/// The names of the curves, each beside a piece of it, in a row below the title.
std::string legendOf(const std::vector<Curve>& curves) {
  std::string svg;
  double x = kLeft;
  for (const Curve& curve : curves) {
    if (curve.name.empty()) continue;
    svg += lineOf("curve " + curve.cssClass, x, kTop, x + kSwatch, kTop) +
           textAt(x + kSwatch + 6, kTop + 4, "start", curve.name);
    x += kSwatch + 6 + kCharacter * static_cast<double>(curve.name.size()) + 18;
  }
  return svg;
}

}  // namespace

Plot convergencePlot(const std::string& title, const std::string& xLabel, std::vector<double> sizes,
                     std::vector<Curve> errors) {
  constexpr double kRounding = 1e-12;
  constexpr double kOrder = 2;
  Plot plot{title, xLabel, std::move(sizes), {}, {}, true};
  for (Curve& curve : errors) {
    Curve line{"", "dashed", {}};
    double factor = std::nan("");
    for (std::size_t i = 0; i < plot.x.size(); ++i) {
      double& error = curve.values[i];
      error = std::abs(error) > kRounding ? 100 * std::abs(error) : std::nan("");
      const double power = std::pow(plot.x[i], kOrder);
      if (std::isnan(factor)) factor = error / power;
      line.values.push_back(factor * power);
    }
    plot.curves.push_back(std::move(line));
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

std::string svgOf(const Plot& plot) {
  const auto scaled = [&](double value) { return plot.logarithmic ? std::log10(value) : value; };
  Axis x;
  Axis y;
  for (const double value : plot.x) x.cover(scaled(value));
  for (const double value : plot.covers) y.cover(scaled(value));
  for (const Curve& curve : plot.curves) {
    for (const double value : curve.values) y.cover(scaled(value));
  }
  for (Axis* axis : {&x, &y}) {
    // Draw values that are equal up to rounding as equal.
    constexpr double kEqual = 1e-9;
    if (axis->low > axis->high) axis->low = axis->high = 0;
    if (axis == &y && y.high - y.low <= kEqual * std::max(std::abs(y.low), std::abs(y.high))) {
      y.low = y.high;
    }
    plot.logarithmic ? addLogarithmicTicks(*axis) : addTicks(*axis, axis == &y);
  }

  const bool hasLegend = std::ranges::count_if(plot.curves, [](const Curve& curve) {
                           return !curve.name.empty();
                         }) > 1;
  const double top = hasLegend ? kTop + kLegendHeight : kTop;
  const auto xOf = [&](double at) { return kLeft + x.fraction(at) * (kRight - kLeft); };
  const auto yOf = [&](double at) { return kBottom - y.fraction(at) * (kBottom - top); };
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\">\n"
      "<text class=\"title\" x=\"{3}\" y=\"18\">{2}</text>\n",
      kWidth, kHeight, escaped(plot.title), kLeft);
  if (hasLegend) svg += legendOf(plot.curves);
  for (const auto& [at, label] : y.ticks) {
    svg += lineOf("grid", kLeft, yOf(at), kRight, yOf(at)) +
           textAt(kLeft - 8, yOf(at) + 4, "end", label);
  }
  for (const auto& [at, label] : x.ticks) {
    if (plot.logarithmic) svg += lineOf("grid", xOf(at), top, xOf(at), kBottom);
    svg += textAt(xOf(at), kBottom + 17, "middle", label);
  }
  svg += textAt((kLeft + kRight) / 2, kHeight - 6, "middle", plot.xLabel);
  for (const Curve& curve : plot.curves) {
    std::string corners;
    std::string dots;
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      const double value = curve.values[i];
      if (!std::isfinite(scaled(value))) continue;
      const std::string tip = fmt::format("{}: {:.9g} at {:.6g}", curve.name, value, plot.x[i]);
      const double left = xOf(scaled(plot.x[i]));
      const double down = yOf(scaled(value));
      corners += fmt::format("{:.1f},{:.1f} ", left, down);
      dots += fmt::format(
          "<circle class=\"dot {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>{}</title></circle>"
          "\n",
          curve.cssClass, left, down, escaped(tip));
    }
    svg += fmt::format("<polyline class=\"curve {}\" points=\"{}\"/>\n", curve.cssClass, corners);
    if (!curve.name.empty() && curve.values.size() <= kMostDots) svg += dots;
  }
  return svg + "</svg>\n";
}

std::string plotsOf(const std::vector<Plot>& plots) {
  std::string html = "<div class=\"plots\">\n";
  for (const Plot& plot : plots) html += svgOf(plot);
  return html + "</div>\n";
}

}  // namespace t4d::tools
