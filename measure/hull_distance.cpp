#include "measure/hull_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace t4d::measure {
namespace {

using model::Point3;
using model::Point4;

/// A difference of two points at equal times, and where it comes from.
struct Difference {
  Point3 offset = Point3::Zero();  // of a less b
  Point4 ofA = Point4::Zero();
};

/// The points of a hull by their times, and the outline of the hull in a direction: how far it
/// reaches at each time, which is a concave chain of some of its points.
class Outline {
 public:
  /// Subtracts the origin, in space, from all points.
  Outline(std::span<const Point4> points, const Point3& origin) : count_(points.size()) {
    for (std::size_t i = 0; i < count_; ++i) {
      points_[i] << points[i].head<3>() - origin, points[i][3];
    }
    const auto end = points_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto isEarlier = [](const Point4& p, const Point4& q) { return p[3] < q[3]; };
    // The layers of a slab are in order.
    if (!std::is_sorted(points_.begin(), end, isEarlier)) {
      std::sort(points_.begin(), end, isEarlier);
    }
  }

  double begin() const { return points_[0][3]; }
  double end() const { return points_[count_ - 1][3]; }
  double farthestFromOrigin() const {
    double most = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      most = std::max(most, points_[i].head<3>().squaredNorm());
    }
    return std::sqrt(most);
  }

  void trace(const Point3& direction) {
    length_ = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Corner corner{points_[i][3], direction.dot(points_[i].head<3>()), i};
      if (length_ > 0 && chain_[length_ - 1].time == corner.time) {
        if (corner.reach <= chain_[length_ - 1].reach) continue;
        --length_;
      }
      while (length_ > 1 && !turnsDown(chain_[length_ - 2], chain_[length_ - 1], corner)) {
        --length_;
      }
      chain_[length_++] = corner;
    }
  }

  std::size_t length() const { return length_; }
  double timeOf(std::size_t corner) const { return chain_[corner].time; }
  double reachOf(std::size_t corner) const { return chain_[corner].reach; }
  const Point4& point(std::size_t corner) const { return points_[chain_[corner].point]; }
  /// The reach at a time between a corner and the next.
  double reachAt(std::size_t corner, double time) const {
    const Corner& p = chain_[corner];
    const Corner& q = chain_[corner + 1];
    return p.reach + (time - p.time) / (q.time - p.time) * (q.reach - p.reach);
  }
  Point4 pointAt(std::size_t corner, double time) const {
    const Point4& p = point(corner);
    if (p[3] == time) return p;
    const Point4& q = point(corner + 1);
    Point4 between = p + (time - p[3]) / (q[3] - p[3]) * (q - p);
    between[3] = time;
    return between;
  }

 private:
  struct Corner {
    double time = 0;
    double reach = 0;
    std::size_t point = 0;
  };
  static bool turnsDown(const Corner& p, const Corner& q, const Corner& r) {
    return (q.reach - p.reach) * (r.time - q.time) > (r.reach - q.reach) * (q.time - p.time);
  }

  std::array<Point4, kMostHullPoints> points_;
  std::size_t count_;
  std::array<Corner, kMostHullPoints> chain_;
  std::size_t length_ = 0;
};

/// The differences of two hulls at equal times.
class Differences {
 public:
  Differences(std::span<const Point4> a, std::span<const Point4> b)
      : a_(a, a[0].head<3>()),
        b_(b, a[0].head<3>()),
        begin_(std::max(a_.begin(), b_.begin())),
        end_(std::min(a_.end(), b_.end())) {}

  bool empty() const { return begin_ > end_; }
  double clampTime(double time) const { return std::clamp(time, begin_, end_); }
  /// No difference is larger.
  double largest() const { return a_.farthestFromOrigin() + b_.farthestFromOrigin(); }

  /// The one farthest in a direction: the sum of both outlines is largest at a corner of one.
  Difference farthest(const Point3& direction) {
    a_.trace(direction);
    b_.trace(-direction);
    std::size_t i = 0;
    std::size_t j = 0;
    double most = -std::numeric_limits<double>::infinity();
    double bestTime = begin_;
    std::size_t bestI = 0;
    std::size_t bestJ = 0;
    for (double time = begin_;;) {
      while (i + 1 < a_.length() && a_.timeOf(i + 1) <= time) ++i;
      while (j + 1 < b_.length() && b_.timeOf(j + 1) <= time) ++j;
      const double reach = reachOf(a_, i, time) + reachOf(b_, j, time);
      if (reach <= most) break;  // concave
      most = reach;
      bestTime = time;
      bestI = i;
      bestJ = j;
      if (time >= end_) break;
      double next = end_;
      if (i + 1 < a_.length()) next = std::min(next, a_.timeOf(i + 1));
      if (j + 1 < b_.length()) next = std::min(next, b_.timeOf(j + 1));
      time = next;
    }
    const Point4 ofA = a_.pointAt(bestI, bestTime);
    return {ofA.head<3>() - b_.pointAt(bestJ, bestTime).head<3>(), ofA};
  }

 private:
  static double reachOf(const Outline& outline, std::size_t corner, double time) {
    return outline.timeOf(corner) == time ? outline.reachOf(corner) : outline.reachAt(corner, time);
  }

  Outline a_;
  Outline b_;
  double begin_;
  double end_;
};

/// Up to four differences, and weights for which their mean is the point of their hull nearest to
/// the origin.
struct Simplex {
  std::array<Difference, 4> corners;
  std::array<double, 4> weights{};
  std::size_t size = 0;

  Difference mean() const {
    Difference mean;
    for (std::size_t i = 0; i < size; ++i) {
      mean.offset += weights[i] * corners[i].offset;
      mean.ofA += weights[i] * corners[i].ofA;
    }
    return mean;
  }
};

/// The weights of the affine combination of some corners nearest to the origin, if they are
/// positive: those of the last corner and of others.
std::optional<std::array<double, 4>> weightsIn(const Simplex& simplex, unsigned others) {
  constexpr double kFlat = 64 * std::numeric_limits<double>::epsilon();
  const std::size_t last = simplex.size - 1;
  const Point3& base = simplex.corners[last].offset;
  std::array<std::size_t, 3> used{};
  std::array<Point3, 3> edges;
  std::size_t count = 0;
  for (std::size_t i = 0; i < last; ++i) {
    if ((others >> i & 1U) == 0) continue;
    used[count] = i;
    edges[count++] = simplex.corners[i].offset - base;
  }
  std::array<double, 3> solved{};
  if (count == 1) {
    const double square = edges[0].squaredNorm();
    if (!(square > 0)) return std::nullopt;
    solved[0] = -base.dot(edges[0]) / square;
  } else if (count == 2) {
    const Point3 normal = edges[0].cross(edges[1]);
    const double square = normal.squaredNorm();
    if (!(square > kFlat * kFlat * edges[0].squaredNorm() * edges[1].squaredNorm())) {
      return std::nullopt;
    }
    solved[0] = -normal.dot(base.cross(edges[1])) / square;
    solved[1] = -normal.dot(edges[0].cross(base)) / square;
  } else if (count == 3) {
    const Point3 normal = edges[1].cross(edges[2]);
    const double volume = edges[0].dot(normal);
    if (!(std::abs(volume) > kFlat * edges[0].norm() * edges[1].norm() * edges[2].norm())) {
      return std::nullopt;
    }
    solved[0] = -base.dot(normal) / volume;
    solved[1] = -base.dot(edges[2].cross(edges[0])) / volume;
    solved[2] = -base.dot(edges[0].cross(edges[1])) / volume;
  }
  std::array<double, 4> weights{};
  double ofLast = 1;
  for (std::size_t k = 0; k < count; ++k) {
    if (!(solved[k] > 0)) return std::nullopt;
    weights[used[k]] = solved[k];
    ofLast -= solved[k];
  }
  if (!(ofLast > 0)) return std::nullopt;
  weights[last] = ofLast;
  return weights;
}

/// Keeps the smallest face of the simplex that has its point nearest to the origin. The last corner
/// is nearer to the origin than the plane through the point that was nearest without it, and so it
/// belongs to that face.
void reduce(Simplex& simplex) {
  double least = std::numeric_limits<double>::infinity();
  Simplex best;
  for (unsigned others = 0; others < 1U << (simplex.size - 1); ++others) {
    const auto weights = weightsIn(simplex, others);
    if (!weights) continue;
    Point3 offset = Point3::Zero();
    for (std::size_t i = 0; i < simplex.size; ++i) {
      offset += (*weights)[i] * simplex.corners[i].offset;
    }
    const double distance = offset.squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    best.size = 0;
    for (std::size_t i = 0; i < simplex.size; ++i) {
      if ((*weights)[i] == 0) continue;
      best.corners[best.size] = simplex.corners[i];
      best.weights[best.size++] = (*weights)[i];
    }
  }
  simplex = best;
}

}  // namespace

std::optional<HullDistance> distanceOf(std::span<const Point4> a, std::span<const Point4> b,
                                       double enough) {
  Differences differences(a, b);
  if (differences.empty()) return std::nullopt;
  constexpr int kMostRounds = 64;
  // A difference has the roundings of two interpolations, some 20 u, and the outlines' corners are
  // chosen by reaches with as many.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const double rounding = kRounding * differences.largest();
  Simplex simplex;
  const Point3 toward = (b[0] - a[0]).head<3>();
  simplex.corners[0] = differences.farthest(toward.isZero(0) ? Point3::UnitX() : toward);
  simplex.weights[0] = 1;
  simplex.size = 1;
  Difference nearest = simplex.mean();
  double bound = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const double distance = nearest.offset.norm();
    if (!(distance > rounding)) break;
    const Point3 direction = nearest.offset / distance;
    const Difference next = differences.farthest(-direction);
    bound = std::max(bound, direction.dot(next.offset) - rounding);
    if (bound > enough || bound >= distance - 2 * rounding || simplex.size == 4) break;
    Simplex grown = simplex;
    grown.corners[grown.size++] = next;
    reduce(grown);
    const Difference found = grown.mean();
    if (grown.size == 0 || !(found.offset.norm() < distance)) break;
    simplex = grown;
    nearest = found;
  }
  const double distance = nearest.offset.norm();
  const Point3 pointA = nearest.ofA.head<3>() + a[0].head<3>();
  return HullDistance{distance, std::min(bound, distance), differences.clampTime(nearest.ofA[3]),
                      pointA, pointA - nearest.offset};
}

}  // namespace t4d::measure
