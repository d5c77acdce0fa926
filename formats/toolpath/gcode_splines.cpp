#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "formats/toolpath/gcode_machine.h"

/// Splines of a GcodeMachine, in its plane: G5, G5.1, and G5.2 to G5.3.
namespace t4d::formats {
namespace {

using Eigen::Vector2d;

/// The parameters from 0 to 1 of chords that stay within the tolerance, without 0.
void divide(const std::function<Vector2d(double)>& curve, double begin, double end,
            double tolerance, int depth, std::vector<double>& chords) {
  const Vector2d from = curve(begin);
  const Vector2d chord = curve(end) - from;
  double off = 0;
  for (const double part : {0.25, 0.5, 0.75}) {
    const Vector2d point = curve(begin + part * (end - begin)) - from;
    const double along = chord.squaredNorm() > 0 ? point.dot(chord) / chord.squaredNorm() : 0;
    off = std::max(off, (point - std::clamp(along, 0.0, 1.0) * chord).norm());
  }
  constexpr int kDeepest = 16;
  if (off <= tolerance || depth >= kDeepest) {
    chords.push_back(end);
    return;
  }
  const double middle = (begin + end) / 2;
  divide(curve, begin, middle, tolerance, depth + 1, chords);
  divide(curve, middle, end, tolerance, depth + 1, chords);
}

/// A point of a rational B-spline whose ends are its first and last point, with even knots between,
/// by de Boor's algorithm. Points have their weights as the third number.
Vector2d nurbsAt(const std::vector<Eigen::Vector3d>& points, std::size_t order, double t) {
  const std::size_t degree = order - 1;
  const std::size_t spans = points.size() - degree;
  const auto knot = [&](std::size_t i) {
    return std::clamp(static_cast<double>(i) - static_cast<double>(degree), 0.0,
                      static_cast<double>(spans));
  };
  const double at = t * static_cast<double>(spans);
  const std::size_t span = std::min(static_cast<std::size_t>(at), spans - 1) + degree;
  std::vector<Eigen::Vector3d> d;
  for (std::size_t i = 0; i <= degree; ++i) {
    const Eigen::Vector3d& point = points[span - degree + i];
    d.emplace_back(point.x() * point.z(), point.y() * point.z(), point.z());
  }
  for (std::size_t r = 1; r <= degree; ++r) {
    for (std::size_t j = degree; j >= r; --j) {
      const std::size_t i = j + span - degree;
      const double width = knot(i + order - r) - knot(i);
      const double part = width > 0 ? (at - knot(i)) / width : 0;
      d[j] = (1 - part) * d[j - 1] + part * d[j];
    }
  }
  return d[degree].head<2>() / d[degree].z();
}

}  // namespace

/// Along a curve in the plane, from 0 to 1, and evenly along the third axis.
Result<void> GcodeMachine::goAlong(const std::function<Vector2d(double)>& curve,
                                   const MachineAxes& to, bool rapid) {
  std::vector<double> chords;
  constexpr int kParts = 8;  // at least, so that no bend hides between two points
  for (int i = 0; i < kParts; ++i) {
    divide(curve, static_cast<double>(i) / kParts, static_cast<double>(i + 1) / kParts,
           options_.tolerance / scaleInPlane(), 0, chords);
  }
  const MachineAxes from = tool_;
  for (const double t : chords) {
    MachineAxes next = to;
    if (t < 1) {
      const Vector2d point = curve(t);
      next[static_cast<std::size_t>(modes_.plane[0])] = point.x();
      next[static_cast<std::size_t>(modes_.plane[1])] = point.y();
      const auto w = static_cast<std::size_t>(modes_.plane[2]);
      next[w] = from[w] + t * (to[w] - from[w]);
    }
    const double seconds = modes_.inverseTime && !rapid
                               ? 60 / inverseFeed_ / static_cast<double>(chords.size())
                               : secondsOf(next, rapid);
    if (auto moved = go(next, seconds, rapid); !moved) return moved;
  }
  return {};
}

/// G5, a cubic with the handles I, J and P, Q, and G5.1, a quadratic with one.
Result<void> GcodeMachine::spline(const GcodeBlock& block, const MachineAxes& to, bool approaches) {
  const bool cubic = *motion_ == 50;
  const std::string word = gcodeWord(*motion_);
  const bool turns = block.axes[3] || block.axes[4] || block.axes[5];
  if (turns || block.r || block.centre[2] || compensation_ || tool_ != at_) {
    return invalid(word + " has X, Y, I, J, P and Q alone, and no compensation of the cutter");
  }
  const auto pair = [&](const std::optional<double>& a, const std::optional<double>& b) {
    return Vector2d(modes_.unit * Vector2d(a.value_or(0), b.value_or(0)));
  };
  const bool begins = block.centre[0] && block.centre[1];
  const bool goesOn = cubic && !block.hasCentre() && splineEnd_;
  if ((!begins && !goesOn) || (cubic && !(block.p && block.q))) {
    return invalid(word + (cubic ? " has no I and J, or no P and Q" : " has no I and J"));
  }
  const auto flat = [&](const MachineAxes& at) {
    return Vector2d(at[static_cast<std::size_t>(modes_.plane[0])],
                    at[static_cast<std::size_t>(modes_.plane[1])]);
  };
  const Vector2d from = flat(at_);
  const Vector2d end = flat(to);
  const Vector2d handle =
      from + (begins ? pair(block.centre[0], block.centre[1]) : Vector2d(-*splineEnd_));
  const Vector2d last = end + pair(block.p, block.q);
  if (cubic) splineEnd_ = pair(block.p, block.q);
  return goAlong(
      [&](double t) {
        const double s = 1 - t;
        if (!cubic) return Vector2d(s * s * from + 2 * s * t * handle + t * t * end);
        return Vector2d(s * s * s * from + 3 * s * s * t * handle + 3 * s * t * t * last +
                        t * t * t * end);
      },
      to, approaches);
}

/// G5.2: a point with its weight P. The first line gives the order L; the tool is at the first
/// point, whose weight a line without X and Y gives.
Result<void> GcodeMachine::addNurbsPoint(const GcodeBlock& block, const MachineAxes& to) {
  if (compensation_ || tool_ != at_) {
    if (!nurbs_) return invalid("G5.2 stands where the cutter is compensated; give G40 before");
  }
  const double weight = block.p.value_or(1);
  if (!(weight > 0)) return invalid(fmt::format("G5.2: the weight P is {:g}", weight));
  const auto point = [&](const MachineAxes& at, double w) {
    return Eigen::Vector3d(at[static_cast<std::size_t>(modes_.plane[0])],
                           at[static_cast<std::size_t>(modes_.plane[1])], w);
  };
  if (!nurbs_) {
    const double order = block.l.value_or(3);
    constexpr double kLargestOrder = 20;
    if (!(order >= 2 && order <= kLargestOrder) || order != std::floor(order)) {
      return invalid(fmt::format("G5.2: the order L is {:g}", order));
    }
    nurbs_ = Nurbs{.order = static_cast<std::size_t>(order), .points = {}};
    nurbs_->points.push_back(point(at_, block.hasAxes() ? 1 : weight));
  }
  if (block.hasAxes()) nurbs_->points.push_back(point(to, weight));
  at_ = to;
  return {};
}

Result<void> GcodeMachine::endNurbs() {
  motion_.reset();
  if (!nurbs_) return invalid("G5.3 ends a spline that G5.2 has not begun");
  const Nurbs nurbs = *std::exchange(nurbs_, std::nullopt);
  if (nurbs.points.size() < nurbs.order) {
    return invalid(
        fmt::format("a spline of the order L{} has {} points", nurbs.order, nurbs.points.size()));
  }
  const MachineAxes end = at_;
  return goAlong([&](double t) { return nurbsAt(nurbs.points, nurbs.order, t); }, end, false);
}

}  // namespace t4d::formats
