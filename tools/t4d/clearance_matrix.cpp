#include "tools/t4d/clearance_matrix.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

using measure::Verdict;

constexpr double kSquare = 18;
constexpr double kCharacter = 6.6;  // about the width of one of 12 pixels
constexpr double kMargin = 12;

using Names = std::vector<std::string>;

std::size_t numberOf(Names& names, const std::string& name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) names.push_back(name);
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

/// How far the meshes stay apart; infinite if they never exist together.
double distanceOf(const CollidedPair& pair) {
  if (pair.collision.contact()) return 0;
  return pair.collision.clearance ? pair.collision.clearance->distance : HUGE_VAL;
}

std::string colourOf(const CollidedPair& pair, double farthest) {
  if (pair.verdict.verdict == Verdict::Hit) return "#c62828";
  if (pair.mayMeet()) return "#ef8c1a";
  constexpr double kLightest = 92;  // percent
  constexpr double kDarkest = 40;
  const double part = std::sqrt(std::min(1.0, distanceOf(pair) / farthest));
  return fmt::format("hsl(210, 60%, {:.0f}%)", kDarkest + (kLightest - kDarkest) * part);
}

std::string titleOf(const CollidedPair& pair, const std::string& lengthUnit) {
  const std::string names = escaped(fmt::format("{} and {}", pair.a.name, pair.b.name));
  if (pair.verdict.verdict == Verdict::Hit) return names + ": hit";
  const double distance = distanceOf(pair);
  if (!std::isfinite(distance)) return names + ": never at the same time";
  return fmt::format("{}: {:.6g} {}", names, distance, lengthUnit);
}

double widthOf(const Names& names) {
  std::size_t longest = 0;
  for (const std::string& name : names) longest = std::max(longest, name.size());
  return kMargin + kCharacter * static_cast<double>(longest);
}

std::string square(double left, double top, std::size_t row, std::size_t column,
                   const std::string& colour, const std::string& title) {
  return fmt::format(
      "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"><title>{}</title></rect>\n",
      left + kSquare * static_cast<double>(column), top + kSquare * static_cast<double>(row),
      kSquare - 1, kSquare - 1, colour, title);
}

}  // namespace

std::string clearanceMatrix(const CollideReport& report, const std::string& lengthUnit) {
  Names rows;
  Names columns;
  double farthest = 0;
  for (const CollidedPair& pair : report.pairs) {
    numberOf(rows, pair.a.name);
    numberOf(columns, pair.b.name);
    const double distance = distanceOf(pair);
    if (std::isfinite(distance)) farthest = std::max(farthest, distance);
  }
  const double left = widthOf(rows);
  constexpr double kTitle = 30;
  const double top = kTitle + widthOf(columns);
  std::string squares;
  for (const CollidedPair& pair : report.pairs) {
    squares += square(left, top, numberOf(rows, pair.a.name), numberOf(columns, pair.b.name),
                      colourOf(pair, farthest), titleOf(pair, lengthUnit));
  }
  constexpr double kBaseline = 13;
  std::string labels;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    labels += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n", left - 4,
                          top + kSquare * static_cast<double>(i) + kBaseline, escaped(rows[i]));
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double x = left + kSquare * static_cast<double>(i) + kBaseline;
    labels += fmt::format("<text transform=\"translate({} {}) rotate(-90)\">{}</text>\n", x,
                          top - 4, escaped(columns[i]));
  }
  constexpr double kLeastWidth = 320;  // of the title
  const double width =
      std::max(kLeastWidth, left + kSquare * static_cast<double>(columns.size()) + kMargin);
  const double height = top + kSquare * static_cast<double>(rows.size()) + kMargin;
  return fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Clearances\">\n"
      "<text class=\"title\" x=\"{}\" y=\"18\">Hits (red), clearances up to {:.4g} {}</text>\n{}{}"
      "</svg>\n",
      width, height, kMargin, farthest, lengthUnit, squares, labels);
}

}  // namespace t4d::tools
