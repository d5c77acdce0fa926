#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "t4d/mesh.h"

namespace t4d::measure {

/// A box in space that moves on straight lines: what contains a cell at each time. Much smaller
/// than one box for all times.
struct MovingBox {
  model::Bounds3 begin;  ///< at time.begin
  model::Bounds3 end;    ///< at time.end
  model::TimeSpan time;
  model::TimeSpan occupied;  ///< within `time`: when there is something in it

  model::Bounds3 at(double t) const {
    if (t <= time.begin) return begin;
    if (t >= time.end) return end;
    const double s = (t - time.begin) / (time.end - time.begin);
    model::Bounds3 box;
    box.min = begin.min + s * (end.min - begin.min);
    box.max = begin.max + s * (end.max - begin.max);
    return box;
  }
  /// Adds a box with the same `time`.
  void add(const MovingBox& other) {
    begin.add(other.begin);
    end.add(other.end);
    occupied.begin = std::min(occupied.begin, other.occupied.begin);
    occupied.end = std::max(occupied.end, other.occupied.end);
  }
};

/// Contains the hull of the points, which lie within the time, at each time. It is larger by more
/// than the rounding of all that is computed with it.
template <class Points>
MovingBox movingBoxOf(const Points& points, const model::TimeSpan& time) {
  MovingBox box{{}, {}, time, {points[0][3], points[0][3]}};
  model::Bounds3 all;
  for (const model::Point4& point : points) {
    all.add(point.head<3>());
    if (point[3] == time.begin) box.begin.add(point.head<3>());
    if (point[3] == time.end) box.end.add(point.head<3>());
    box.occupied.begin = std::min(box.occupied.begin, point[3]);
    box.occupied.end = std::max(box.occupied.end, point[3]);
  }
  if (box.begin.empty() || box.end.empty()) {
    box.begin = box.end = all;
  } else {
    for (const model::Point4& point : points) {
      if (point[3] == time.begin || point[3] == time.end) continue;
      const model::Bounds3 here = box.at(point[3]);
      const model::Point3 below = (here.min - point.head<3>()).cwiseMax(0);
      const model::Point3 above = (point.head<3>() - here.max).cwiseMax(0);
      box.begin.min -= below;
      box.end.min -= below;
      box.begin.max += above;
      box.end.max += above;
    }
  }
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const double pad =
      kRounding * std::max(all.min.cwiseAbs().maxCoeff(), all.max.cwiseAbs().maxCoeff());
  for (model::Bounds3* bounds : {&box.begin, &box.end}) {
    bounds->min.array() -= pad;
    bounds->max.array() += pad;
  }
  return box;
}

/// The time when both contain something.
inline std::optional<model::TimeSpan> commonTime(const MovingBox& a, const MovingBox& b) {
  const model::TimeSpan common{std::max(a.occupied.begin, b.occupied.begin),
                               std::min(a.occupied.end, b.occupied.end)};
  if (common.begin > common.end) return std::nullopt;
  return common;
}

/// A span that contains all times when the boxes meet.
inline std::optional<model::TimeSpan> meetingTime(const MovingBox& a, const MovingBox& b) {
  const auto common = commonTime(a, b);
  if (!common) return std::nullopt;
  const model::Bounds3 a0 = a.at(common->begin);
  const model::Bounds3 a1 = a.at(common->end);
  const model::Bounds3 b0 = b.at(common->begin);
  const model::Bounds3 b1 = b.at(common->end);
  double low = 0;
  double high = 1;
  // They are apart where the gap, linear in time, is positive.
  const auto clip = [&](double gap0, double gap1) {
    if (gap0 > 0 && gap1 > 0) {
      high = -1;
    } else if (gap0 > 0) {
      low = std::max(low, gap0 / (gap0 - gap1));
    } else if (gap1 > 0) {
      high = std::min(high, gap0 / (gap0 - gap1));
    }
  };
  for (int axis = 0; axis < 3 && low <= high; ++axis) {
    clip(a0.min[axis] - b0.max[axis], a1.min[axis] - b1.max[axis]);
    clip(b0.min[axis] - a0.max[axis], b1.min[axis] - a1.max[axis]);
  }
  if (low > high) return std::nullopt;
  constexpr double kMargin = 1e-12;
  const double length = common->end - common->begin;
  return model::TimeSpan{std::max(common->begin, common->begin + (low - kMargin) * length),
                         std::min(common->end, common->begin + (high + kMargin) * length)};
}

/// No two points of the boxes at equal times are nearer; infinite if they have no time in common.
inline double leastDistance(const MovingBox& a, const MovingBox& b) {
  const auto common = commonTime(a, b);
  if (!common) return std::numeric_limits<double>::infinity();
  constexpr int kParts = 4;
  constexpr double kDown = 1 - 64 * std::numeric_limits<double>::epsilon();
  const model::Bounds3 a0 = a.at(common->begin);
  const model::Bounds3 a1 = a.at(common->end);
  const model::Bounds3 b0 = b.at(common->begin);
  const model::Bounds3 b1 = b.at(common->end);
  // Between the two, the gaps on either side are linear in time.
  const std::pair<model::Point3, model::Point3> first(a0.min - b0.max, b0.min - a0.max);
  const std::pair<model::Point3, model::Point3> slope(a1.min - b1.max - first.first,
                                                      b1.min - a1.max - first.second);
  const auto gapsAt = [&](int part) {
    const double s = part / static_cast<double>(kParts);
    return std::pair<model::Point3, model::Point3>(first.first + s * slope.first,
                                                   first.second + s * slope.second);
  };
  double least = std::numeric_limits<double>::infinity();
  auto before = first;
  for (int part = 1; part <= kParts; ++part) {
    const auto after = gapsAt(part);
    // Along each axis the gap is linear on either side, so it is smallest at an end.
    const model::Point3 gap = before.first.cwiseMin(after.first)
                                  .cwiseMax(before.second.cwiseMin(after.second))
                                  .cwiseMax(0);
    least = std::min(least, gap.squaredNorm());
    before = after;
  }
  return kDown * std::sqrt(least);
}

}  // namespace t4d::measure
