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

/// An <svg> element: errors over sizes with logarithmic axes of equal scale, so that an error of
/// order p is a line of slope p; dashed beside each curve, with the class `order`, one of slope
/// `order`.
std::string convergencePlot(const std::string& title, const std::string& xLabel,
                            const std::vector<ErrorCurve>& curves, double order);

}  // namespace t4d::tools
