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

/// An <svg> element: errors over sizes with logarithmic axes, so that errors of one order are
/// parallel lines; dashed beside each curve, with the class `order`, one of order `order`.
struct ConvergencePlot {
  std::string title;
  std::string xLabel;
  std::vector<ErrorCurve> curves;
  double order = 2;
  std::pair<double, double> sizes;   ///< the smallest and the largest to show
  std::pair<double, double> errors;  ///< likewise
};
std::string svgOf(const ConvergencePlot& plot);

}  // namespace t4d::tools
