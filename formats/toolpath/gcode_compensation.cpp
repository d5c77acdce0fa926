#include "formats/toolpath/gcode_compensation.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace t4d::formats {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;
constexpr double kCorner = 0.05;  // radians; as in LinuxCNC, less is none

Vector2d unit(double radians) { return {std::cos(radians), std::sin(radians)}; }

double angleOf(const Vector2d& vector) { return std::atan2(vector.y(), vector.x()); }

Error tooNarrow() {
  return invalid("an inner corner is too narrow for the cutter, whose path crosses itself there");
}

/// The arc about a centre, as another one turns.
Arc arcAbout(const Vector2d& centre, const Vector2d& from, const Vector2d& to, double turns) {
  const double sign = turns > 0 ? 1 : -1;
  Arc arc{centre, from - centre, (to - centre).norm()};
  const Vector2d end = to - centre;
  double angle = std::atan2(arc.begin.x() * end.y() - arc.begin.y() * end.x(), arc.begin.dot(end));
  if (sign * angle <= 0) angle += sign * 2 * kPi;
  arc.radians = angle;
  return arc;
}

}  // namespace

CutterCompensation::CutterCompensation(std::array<int, 3> plane, bool left, double radius,
                                       const MachineAxes& at, Emit emit)
    : plane_(plane),
      left_(left),
      radius_(radius),
      emit_(std::move(emit)),
      programmed_(at),
      beside_(flat(at)),
      placed_(flat(at)) {}

Vector2d CutterCompensation::flat(const MachineAxes& at) const {
  return {at[static_cast<std::size_t>(plane_[0])], at[static_cast<std::size_t>(plane_[1])]};
}

MachineAxes CutterCompensation::at(const Vector2d& flat, const MachineAxes& others) const {
  MachineAxes placed = others;
  placed[static_cast<std::size_t>(plane_[0])] = flat.x();
  placed[static_cast<std::size_t>(plane_[1])] = flat.y();
  return placed;
}

Result<void> CutterCompensation::release() {
  for (const CompensatedMove& move : std::exchange(held_, {})) {
    if (auto done = emit_(move); !done) return done;
    placed_ = flat(move.to);
  }
  return {};
}

/// Lets the moves that are held end there: one in the plane, and those along the third axis behind
/// it.
Result<void> CutterCompensation::cutOff(const Vector2d& end) {
  for (CompensatedMove& move : held_) {
    if (move.arc && !move.isCorner) {
      const double before = std::abs(move.arc->radians);
      const double turns = before > 2 * kPi ? std::floor(before / (2 * kPi)) : 0;
      Arc arc = arcAbout(move.arc->centre, placed_, end, move.arc->radians);
      arc.radians += (arc.radians > 0 ? 1 : -1) * 2 * kPi * turns;
      constexpr double kLonger = 0.0254;
      if (std::abs(arc.radians) > before + kLonger) return tooNarrow();
      move.arc = arc;
    } else if (!move.arc && move.direction.dot(end - placed_) < 0) {
      return tooNarrow();
    }
    move.to = at(end, move.to);
  }
  return release();
}

void CutterCompensation::begin(const MachineAxes& to, bool rapid, double feed) {
  const double alpha = angleOf(flat(to) - flat(programmed_)) + side() * kPi / 2;
  beside_ = flat(to) + radius_ * unit(alpha);
  held_.push_back({.to = at(beside_, to), .rapid = rapid, .feed = feed, .direction = unit(alpha)});
}

Result<void> CutterCompensation::straight(const MachineAxes& to, bool rapid, double feed) {
  const Vector2d from = flat(programmed_);
  const Vector2d end = flat(to);
  if (isFirst_) {
    if ((end - from).norm() <= radius_) {
      return invalid("the first move with G41 or G42 is not longer than the radius of the cutter");
    }
    isFirst_ = false;
    begin(to, rapid, feed);
    // The way to it is its own, whatever its direction.
    held_.back().direction.setZero();
    programmed_ = to;
    return {};
  }
  if (end == from) {
    held_.push_back({.to = at(beside_, to), .rapid = rapid, .feed = feed});
    programmed_ = to;
    return {};
  }
  double theta = angleOf(beside_ - from);
  double alpha = angleOf(end - from);
  double beta = 0;
  if (left_) {
    if (theta < alpha) theta += 2 * kPi;
    beta = theta - alpha - kPi / 2;
  } else {
    if (alpha < theta) alpha += 2 * kPi;
    beta = alpha - theta - kPi / 2;
  }
  const double gamma = side() * kPi / 2;
  const bool afterArc = !held_.empty() && held_.front().arc && !held_.front().isCorner;
  const bool turnsBack =
      beta > kPi - kCorner && afterArc && (held_.front().arc->radians > 0) != left_;
  const bool isInner = beta < -kCorner || beta > kPi + kCorner || turnsBack;
  if (isInner) {
    Vector2d corner;
    if (afterArc) {
      const auto found = cornerAfterArc(*held_.front().arc, end);
      if (!found) return found.error();
      corner = *found;
    } else {
      const double half = (beta + kPi) / 2;
      if (half == 0) return tooNarrow();
      corner = beside_ + radius_ / std::tan(half) * unit(theta + gamma);
    }
    if (auto done = cutOff(corner); !done) return done;
  } else if (beta > kCorner) {
    if (auto done = cutOff(beside_); !done) return done;
    if (auto done = goAround(from + radius_ * unit(alpha + gamma), feed, rapid); !done) return done;
  } else if (auto done = release(); !done) {
    return done;
  }
  beside_ = end + radius_ * unit(alpha + gamma);
  held_.push_back({.to = at(beside_, to), .rapid = rapid, .feed = feed, .direction = end - from});
  programmed_ = to;
  return {};
}

/// About a corner, to beside the next move.
Result<void> CutterCompensation::goAround(const Vector2d& end, double feed, bool rapid) {
  CompensatedMove move{.to = at(end, programmed_), .rapid = rapid, .feed = feed, .isCorner = true};
  if (!rapid) move.arc = arcAbout(flat(programmed_), beside_, end, -side());
  held_.push_back(move);
  return release();
}

/// Where a straight move meets the arc before it.
Result<Vector2d> CutterCompensation::cornerAfterArc(const Arc& before, const Vector2d& to) const {
  const Vector2d from = flat(programmed_);
  const double turn = before.radians > 0 ? 1 : -1;
  const double radius = before.endRadius;
  const double theta = angleOf(to - from) + turn * kPi / 2;
  const double phi = angleOf(before.centre - from);
  const bool inside = isInside(before.radians);
  const double distance = (radius + (inside ? radius_ : -radius_)) * std::cos(theta - phi);
  const double part = (distance + (inside ? -radius_ : radius_)) / radius;
  if (!(std::abs(part) <= 1)) return tooNarrow();
  const double angle = theta + kPi + (inside ? -turn : turn) * std::acos(part);
  return Vector2d(before.centre + radius * unit(angle));
}

/// The radius of the path of the cutter beside an arc.
double CutterCompensation::radiusOf(const Arc& arc) const {
  return arc.endRadius + (isInside(arc.radians) ? -radius_ : radius_);
}

/// Where an arc meets the straight move before it.
Result<Vector2d> CutterCompensation::cornerBeforeArc(const Arc& next, double theta,
                                                     double beta) const {
  const double up = next.endRadius * std::sin(beta - kPi / 2);
  const double radius = radiusOf(next);
  const double turn = next.radians > 0 ? 1 : -1;
  const bool inside = isInside(next.radians);
  const double part = (up + (inside ? radius_ : -radius_)) / radius;
  if (!(std::abs(part) <= 1)) return tooNarrow();
  const double angle =
      inside ? theta + turn * std::asin(part) : theta + kPi - turn * std::asin(part);
  return Vector2d(next.centre + radius * unit(angle));
}

Result<Vector2d> CutterCompensation::cornerOfArcs(const Arc& before, const Arc& next) const {
  const double old = before.endRadius;
  const double radius = radiusOf(next);
  const Vector2d between = next.centre - before.centre;
  const double distance = between.norm();
  if (!(old > 0 && distance > 0)) return tooNarrow();
  const double part = (old * old + distance * distance - radius * radius) / (2 * old * distance);
  if (!(std::abs(part) <= 1)) return tooNarrow();
  const double turn = next.radians > 0 ? 1 : -1;
  const double back = (isInside(before.radians) ? turn : -turn) * std::acos(part);
  return Vector2d(before.centre + old * unit(angleOf(between) + back));
}

Result<void> CutterCompensation::beginArc(const Arc& arc, const MachineAxes& to, double feed) {
  const Vector2d from = flat(programmed_);
  const bool inside = isInside(arc.radians);
  const Vector2d programmedEnd = flat(to);
  const Vector2d end =
      programmedEnd + (inside ? -radius_ : radius_) * (programmedEnd - arc.centre).normalized();
  // The centre on the line of the end, as far from where the tool is.
  const double half = (from - end).norm() / 2;
  const double direction = angleOf(arc.centre - end);
  const double cosine = std::cos(angleOf(from - end) - direction);
  if (std::abs(cosine) < 1e-6) return tooNarrow();
  const Vector2d centre = end + half / cosine * unit(direction);
  beside_ = end;
  held_.push_back(
      {.to = at(end, to), .feed = feed, .arc = arcAbout(centre, from, end, arc.radians)});
  return {};
}

Result<void> CutterCompensation::arc(const ArcWords& words, const MachineAxes& to, double feed) {
  auto read = arcOf(words);
  if (!read) return read.error();
  Arc arc = *read;
  if (isFirst_) {
    if ((words.to - words.from).norm() <= radius_) {
      return invalid("the first arc with G41 or G42 is not wider than the radius of the cutter");
    }
    isFirst_ = false;
    auto begun = beginArc(arc, to, feed);
    programmed_ = to;
    return begun;
  }
  const Vector2d from = words.from;
  const bool counter = arc.radians > 0;
  const bool inside = isInside(arc.radians);
  const double theta = angleOf(beside_ - from) - side() * kPi / 2;
  double delta = angleOf(arc.centre - from);
  const double alpha = delta + (counter ? -kPi / 2 : kPi / 2);
  double beta = left_ ? theta - alpha : alpha - theta;
  beta = beta > 1.5 * kPi ? beta - 2 * kPi : beta < -kPi / 2 ? beta + 2 * kPi : beta;
  if (inside && arc.endRadius <= radius_) {
    return invalid("an inner arc is not wider than the cutter");
  }
  if (!inside) delta += kPi;
  const Vector2d outward = (words.to - arc.centre).normalized();
  const Vector2d end = words.to + (inside ? -radius_ : radius_) * outward;
  const bool isInner =
      beta < -kCorner || beta > kPi + kCorner || (std::abs(beta - kPi) < kCorner && !inside);
  Vector2d begin = beside_;
  if (isInner) {
    const bool afterArc = !held_.empty() && held_.front().arc && !held_.front().isCorner;
    const auto corner =
        afterArc ? cornerOfArcs(*held_.front().arc, arc) : cornerBeforeArc(arc, theta, beta);
    if (!corner) return corner.error();
    if (auto done = cutOff(*corner); !done) return done;
    begin = *corner;
  } else {
    if (auto done = release(); !done) return done;
    if (beta > kCorner) {
      begin = from + radius_ * unit(delta);
      if (auto done = goAround(begin, feed, false); !done) return done;
    }
  }
  Arc path = arcAbout(arc.centre, begin, end, arc.radians);
  const double turns = std::floor(std::abs(arc.radians) / (2 * kPi) - 1e-9);
  path.radians += (counter ? 1 : -1) * 2 * kPi * turns;
  held_.push_back({.to = at(end, to), .feed = feed, .arc = path});
  beside_ = end;
  programmed_ = to;
  return {};
}

Result<void> CutterCompensation::end() { return release(); }

}  // namespace t4d::formats
