#pragma once

#include <string>
#include <vector>

namespace t4d::tools {

/// A curve of a plot, drawn with the CSS classes `curve` and `cssClass`: `a`, `b`, `d` or `dashed`.
/// Values that the axes cannot show are skipped: those that are not finite and, on logarithmic
/// axes, those that are not positive.
struct Curve {
  std::string name;  ///< "" to leave it out of the legend
  std::string cssClass;
  std::vector<double> values;  ///< one per x of the plot
};

struct Plot {
  std::string title;
  std::string xLabel;
  std::vector<double> x;  ///< none: axes alone
  std::vector<Curve> curves;
  std::vector<double> covers = {};  ///< values that the y axis reaches in any case, such as 0
  bool logarithmic = false;         ///< both axes
};

/// Errors, given as fractions, in percent over the sizes of voxels, on logarithmic axes; errors
/// that are no more than rounding are skipped. From the first point of each curve a dashed line
/// shows convergence of order 2.
Plot convergencePlot(const std::string& title, const std::string& xLabel, std::vector<double> sizes,
                     std::vector<Curve> errors);

/// An <svg> element, with a legend if several curves have names.
std::string svgOf(const Plot& plot);

/// Plots side by side, for a page.
std::string plotsOf(const std::vector<Plot>& plots);

}  // namespace t4d::tools
