#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace t4d::tools {

/// A curve of a plot, drawn with the CSS classes `curve` and `cssClass`. Values that are not finite
/// are skipped.
struct Curve {
  std::string name;
  std::string cssClass;
  std::vector<double> values;  ///< one per x of the plot
};

struct Plot {
  std::string title;
  std::string xLabel;
  std::vector<double> x;  ///< increasing; none: axes alone
  std::vector<Curve> curves;
  bool fromZero = false;  ///< the y axis starts at 0
};

/// A title or label with its unit: "Volume [mm³]"; the text alone where the unit is not known.
std::string labelled(const std::string& text, const std::string& unit, std::string_view power = {});

/// An <svg> element, with a legend if there are several curves. Its colours come from the CSS
/// classes `axis` and `grid`, and from those of the curves.
std::string svgOf(const Plot& plot);

}  // namespace t4d::tools
