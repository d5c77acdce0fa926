#pragma once

#include <string>
#include <vector>

namespace t4d::tools {

/// A picture with a plot area inside its margins, for plots of any kind of axes. Positions are in
/// pixels from the top left. Colours are those of the CSS classes `title`, `axis`, `grid`, `curve`,
/// `dot`, and of each curve.
class SvgCanvas {
 public:
  struct Size {
    double width, height;
    double left;  ///< margin, with room for the labels of the y axis
    double top;   ///< margin, with room for the title
  };
  SvgCanvas(const Size& size, const std::string& title);

  double left() const { return size_.left; }
  double right() const;
  double top() const { return size_.top; }
  double bottom() const;

  /// A line across the plot area, labelled at the y axis.
  void addRow(double y, const std::string& label);
  /// A label at the x axis, and with `line` a line up from it.
  void addColumn(double x, const std::string& label, bool line);
  /// The name of the x axis.
  void addAxisName(const std::string& name);

  struct Point {
    double x, y;
    std::string tip;  ///< shown when the mouse is over it
  };
  void addCurve(const std::string& cssClass, const std::vector<Point>& points);
  void addLine(const std::string& cssClass, double x1, double y1, double x2, double y2);
  void addText(double x, double y, const std::string& text);

  /// The whole <svg> element.
  std::string finish() const { return svg_ + "</svg>\n"; }

 private:
  Size size_;
  std::string svg_;
};

}  // namespace t4d::tools
