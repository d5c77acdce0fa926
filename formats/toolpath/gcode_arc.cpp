#include "formats/toolpath/gcode_arc.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "t4d/motion.h"

namespace t4d::formats {
namespace {

/// How far an arc's start and end may be from one circle, as in LinuxCNC: by this, by more if it is
/// less than a thousandth of the radius, and never by a hundred times this. Programs in inches have
/// one digit more.
double arcRounding(const ArcWords& arc) {
  return arc.unit == 1 ? 2e-2 * std::numbers::sqrt2 : 2e-3 * std::numbers::sqrt2 * arc.unit;
}
constexpr double kArcRoundingPart = 0.001;
constexpr double kLargestRoundings = 100;

// The radius of a half circle, whose digits are rounded, may be less than its half chord.
constexpr double kRadiusRounding = 0.01;

Result<Eigen::Vector2d> centreByRadius(const ArcWords& arc) {
  const Eigen::Vector2d chord = arc.to - arc.from;
  const double length = chord.norm();
  const double radius = *arc.radius;
  if (!(length > 0)) return invalid("an arc by radius ends where it begins; give its centre");
  if (length / 2 > std::abs(radius) + kRadiusRounding) {
    return invalid(
        fmt::format("the ends of the arc are {:.6g} mm apart, and its radius is {:.6g} mm", length,
                    std::abs(radius)));
  }
  const double square = radius * radius - length * length / 4;
  const double away = std::sqrt(std::max(square, 0.0)) / length;
  const double side = (radius > 0) == arc.clockwise ? -1 : 1;
  return Eigen::Vector2d(arc.from + chord / 2 +
                         side * away * Eigen::Vector2d(-chord.y(), chord.x()));
}

Result<Eigen::Vector2d> centreOf(const ArcWords& arc) {
  if (arc.radius && arc.centre) return invalid("an arc has both a radius and a centre");
  if (arc.radius) return centreByRadius(arc);
  if (!arc.centre) return invalid("an arc has neither centre (I, J, K) nor radius (R)");
  return *arc.centre;
}

}  // namespace

Eigen::Vector2d Arc::at(double part) const {
  const double turn = part * radians;
  const double scale = (1 - part) + part * endRadius / begin.norm();
  return centre + scale * Eigen::Vector2d(std::cos(turn) * begin.x() - std::sin(turn) * begin.y(),
                                          std::sin(turn) * begin.x() + std::cos(turn) * begin.y());
}

Result<Arc> arcOf(const ArcWords& words) {
  const auto centre = centreOf(words);
  if (!centre) return centre.error();
  if (!(words.turns >= 1) || words.turns != std::floor(words.turns)) {
    return invalid(
        fmt::format("P{:g}, the turns of an arc, is not a whole number above zero", words.turns));
  }
  const Eigen::Vector2d end = words.to - *centre;
  Arc arc{*centre, words.from - *centre, end.norm()};
  const double radius = arc.begin.norm();
  if (!(radius > 0)) return invalid("the arc begins at its centre");
  const double off = std::abs(radius - arc.endRadius);
  const double rounding = arcRounding(words);
  if (off > kLargestRoundings * rounding ||
      (off > rounding && off > kArcRoundingPart * std::max(radius, arc.endRadius))) {
    return invalid(
        fmt::format("the arc begins {:.6g} mm from its centre and ends {:.6g} mm from it", radius,
                    arc.endRadius));
  }
  constexpr double kTurn = 2 * std::numbers::pi;
  const Eigen::Vector2d& begin = arc.begin;
  double angle = std::atan2(begin.x() * end.y() - begin.y() * end.x(), begin.dot(end));
  if (words.from == words.to) angle = 0;  // a full circle
  if (words.clockwise && angle >= 0) angle -= kTurn;
  if (!words.clockwise && angle <= 0) angle += kTurn;
  arc.radians = angle + (words.clockwise ? -1 : 1) * kTurn * (words.turns - 1);
  return arc;
}

Result<std::uint64_t> chordsOfArc(const Arc& arc, double tolerance) {
  const double largest = std::max(arc.begin.norm(), arc.endRadius);
  const double step =
      tolerance < largest ? 2 * std::acos(1 - tolerance / largest) : std::numbers::pi / 2;
  const double chords = std::ceil(std::abs(arc.radians) / std::min(step, std::numbers::pi / 4));
  if (!(chords <= static_cast<double>(model::kMaxSegments))) {
    return invalid(fmt::format("the arc has {:.3g} chords of the tolerance {}; allow a larger one",
                               chords, tolerance));
  }
  return static_cast<std::uint64_t>(chords);
}

}  // namespace t4d::formats
