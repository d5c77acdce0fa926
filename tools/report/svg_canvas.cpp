#include "tools/report/svg_canvas.h"

#include <iterator>

#include <fmt/format.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

constexpr double kRight = 14;
constexpr double kBottom = 40;
constexpr double kTitleBaseline = 18;
/// More dots would only thicken the curve.
constexpr std::size_t kMostDots = 2000;

std::string textAt(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format(
      "<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
      escaped(text));
}

}  // namespace

SvgCanvas::SvgCanvas(const Size& size, const std::string& title)
    : size_(size),
      svg_(fmt::format("<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\">\n"
                       "<text class=\"title\" x=\"{3}\" y=\"{4}\">{2}</text>\n",
                       size.width, size.height, escaped(title), size.left, kTitleBaseline)) {}

double SvgCanvas::right() const { return size_.width - kRight; }
double SvgCanvas::bottom() const { return size_.height - kBottom; }

void SvgCanvas::addRow(double y, const std::string& label) {
  addLine("grid", left(), y, right(), y);
  svg_ += textAt(left() - 8, y + 4, "end", label);
}

void SvgCanvas::addColumn(double x, const std::string& label, bool line) {
  if (line) addLine("grid", x, top(), x, bottom());
  svg_ += textAt(x, bottom() + 17, "middle", label);
}

void SvgCanvas::addAxisName(const std::string& name) {
  svg_ += textAt((left() + right()) / 2, size_.height - 6, "middle", name);
}

void SvgCanvas::addCurve(const std::string& cssClass, const std::vector<Point>& points) {
  std::string corners;
  for (const Point& point : points) corners += fmt::format("{:.1f},{:.1f} ", point.x, point.y);
  auto out = std::back_inserter(svg_);
  fmt::format_to(out, "<polyline class=\"curve {}\" points=\"{}\"/>\n", cssClass, corners);
  if (points.size() > kMostDots) return;
  for (const Point& point : points) {
    fmt::format_to(out,
                   "<circle class=\"dot {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\">"
                   "<title>{}</title></circle>\n",
                   cssClass, point.x, point.y, escaped(point.tip));
  }
}

void SvgCanvas::addLine(const std::string& cssClass, double x1, double y1, double x2, double y2) {
  svg_ +=
      fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n",
                  cssClass, x1, y1, x2, y2);
}

void SvgCanvas::addText(double x, double y, const std::string& text) {
  svg_ += textAt(x, y, "start", text);
}

}  // namespace t4d::tools
