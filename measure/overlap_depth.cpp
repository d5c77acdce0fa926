#include "measure/overlap_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

namespace t4d::measure {

using model::Point3;

OverlapDepth::OverlapDepth(const model::TriangleMesh& a, const model::TriangleMesh& b)
    : treeA_(a), treeB_(b), windingA_(a), windingB_(b), parts_(commonParts(a, b)) {
  // The coordinates of both surfaces are rounded where they reach each other.
  model::Bounds3 common = boundsOf(a);
  const model::Bounds3 other = boundsOf(b);
  common.min = common.min.cwiseMax(other.min);
  common.max = common.max.cwiseMin(other.max);
  if (!common.empty()) {
    largest_ = std::max(common.min.cwiseAbs().maxCoeff(), common.max.cwiseAbs().maxCoeff());
  }
}

/// The lesser of the depths in the two solids, less a length for each; negative outside of one.
/// Points that are a distance apart have values that differ by that distance at most. A value up to
/// `most` may be too large, but not larger than that, where it takes long to tell inside from
/// outside: near a surface.
double OverlapDepth::at(const Point3& point, double lessA, double lessB, double most) const {
  const auto depthIn = [&](const TriangleTree& tree, const WindingNumber& winding, double less) {
    constexpr double kSure = 0.25;  // far more than `at` is off
    const double distance = tree.nearest(point).distance;
    double number = winding.at(point) - 0.5;
    if (std::abs(number) <= kSure) {
      if (distance - less <= most) return distance - less;
      number = winding.exactAt(point) - 0.5;
    }
    return (number > 0 ? distance : -distance) - less;
  };
  return std::min(depthIn(treeA_, windingA_, lessA), depthIn(treeB_, windingB_, lessB));
}

/// By branch and bound over boxes, those that may hold the most first.
double OverlapDepth::greatest(double lessA, double lessB, bool any) const {
  constexpr int kMostBoxes = 3'000;  // besides one about each part
  constexpr double kEnough = 1.02;
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const double least = kRounding * largest_;
  struct Box {
    Point3 center;
    Point3 half;
    double mostInIt = 0;
  };
  const auto isLess = [](const Box& p, const Box& q) { return p.mostInIt < q.mostInIt; };
  std::priority_queue<Box, std::vector<Box>, decltype(isLess)> boxes(isLess);
  double most = least;
  const auto add = [&](const Point3& center, const Point3& half) {
    const double here = at(center, lessA, lessB, most);
    most = std::max(most, here);
    boxes.push({center, half, here + half.norm()});
  };
  for (const CommonPart& part : parts_) {
    const auto& [low, high] = part.bounds;
    add((low + high) / 2, (high - low) / 2);
  }
  for (int count = 0; count < kMostBoxes && !boxes.empty(); count += 2) {
    if (!(boxes.top().mostInIt > kEnough * most) || (any && most > least)) break;
    Box box = boxes.top();
    boxes.pop();
    // Halved along its longest side.
    int axis = 0;
    box.half.maxCoeff(&axis);
    box.half[axis] /= 2;
    const Point3 by = box.half[axis] * Point3::Unit(axis);
    add(box.center - by, box.half);
    add(box.center + by, box.half);
  }
  return most > least ? most : 0;
}

}  // namespace t4d::measure
