#pragma once

#include <string>
#include <utility>
#include <vector>

namespace t4d::tools {

/// Errors over sizes, both positive; `cssClass` as in svg_plot.h.
struct ErrorCurve {
  std::string name;
  std::string cssClass;
  std::vector<std::pair<double, double>> points;  ///< size, error
};

/// An <svg> element: errors over sizes with logarithmic axes, on which errors of the same order lie
/// on parallel lines. A dashed line of order `order` starts at each curve's first point, with the
/// CSS class `order`.
struct ConvergencePlot {
  std::string title;
  std::string xLabel;
  std::vector<ErrorCurve> curves;
  double order = 2;
  std::pair<double, double> sizes;   ///< the smallest and the largest shown
  std::pair<double, double> errors;  ///< likewise
};
std::string svgOf(const ConvergencePlot& plot);

}  // namespace t4d::tools
