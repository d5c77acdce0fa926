#include "measure/overlap_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include <Eigen/Eigenvalues>

namespace t4d::measure {

using model::Point3;

namespace {

/// The largest coordinate of what both bounds have in common: those of both surfaces are rounded
/// where they reach each other.
double largestCommon(const model::TriangleMesh& a, const model::TriangleMesh& b) {
  model::Bounds3 common = boundsOf(a);
  const model::Bounds3 other = boundsOf(b);
  common.min = common.min.cwiseMax(other.min);
  common.max = common.max.cwiseMin(other.max);
  if (common.empty()) return 0;
  return std::max(common.min.cwiseAbs().maxCoeff(), common.max.cwiseAbs().maxCoeff());
}

/// No depth in a part is larger: a ball in it finds room between planes, across the axes and across
/// the direction in which its corners spread least.
double mostIn(const CommonPart& part) {
  double width = (part.bounds.max - part.bounds.min).minCoeff();
  Point3 mean = Point3::Zero();
  for (const Point3& corner : part.corners) mean += corner;
  mean /= static_cast<double>(std::max<std::size_t>(1, part.corners.size()));
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Point3& corner : part.corners) {
    spread += (corner - mean) * (corner - mean).transpose();
  }
  const Point3 across =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  if (!across.allFinite() || part.corners.empty()) return width / 2;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const Point3& corner : part.corners) {
    least = std::min(least, across.dot(corner - mean));
    most = std::max(most, across.dot(corner - mean));
  }
  return std::min(width, most - least) / 2;
}

}  // namespace

double OverlapDepth::most() const {
  double most = 0;
  for (const CommonPart& part : parts_) {
    most = std::max(most, mostIn(part));
  }
  return most;
}

/// Of a point that is so far from the surface. If it is less far `away` from another one than that
/// is from the surface, it is on its side. Near the surface, where it takes long to tell inside
/// from outside, depths up to `enough` are not sure.
OverlapDepth::Depth OverlapDepth::depthOf(const Point3& point, double distance,
                                          const WindingNumber& winding, double enough,
                                          const Depth& near, double away) {
  constexpr double kSure = 0.25;  // far more than `at` is off
  if (near.isSure && std::abs(near.value) > away) {
    return {near.value > 0 ? distance : -distance, true};
  }
  double number = winding.at(point) - 0.5;
  if (std::abs(number) <= kSure) {
    if (distance <= enough) return {distance, false};
    number = winding.exactAt(point) - 0.5;
  }
  return {number > 0 ? distance : -distance, true};
}

/// By branch and bound over boxes, those that may hold the most first: the lesser of the depths in
/// the two solids differs between two points by their distance at most.
double OverlapDepth::greatest(double lessA, double lessB, bool any, double least) const {
  constexpr int kMostBoxes = 3'000;  // besides one about each part
  constexpr double kEnough = 1.02;
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  least = std::max(least, kRounding * largestCommon(a_, b_));
  if (!(this->most() - std::min(lessA, lessB) > least)) return 0;
  if (!solidA_) solidA_.emplace(a_);
  if (!solidB_) solidB_.emplace(b_);
  struct Box {
    Point3 center = Point3::Zero();
    Point3 half = Point3::Zero();
    Depth inA = {};
    Depth inB = {};
    double mostInPart = 0;
    double mostInIt = 0;
  };
  const auto isLess = [](const Box& p, const Box& q) { return p.mostInIt < q.mostInIt; };
  std::priority_queue<Box, std::vector<Box>, decltype(isLess)> boxes(isLess);
  double most = least;
  const double saved = std::min(lessA, lessB);
  const auto add = [&](const Point3& center, const Point3& half, const Box& from, double away) {
    Box box{.center = center, .half = half, .mostInPart = from.mostInPart};
    const double radius = half.norm();
    const auto mayBeDeeper = [&](double depth) {
      return std::min(depth + radius, from.mostInPart) > kEnough * most;
    };
    // What cannot be deeper needs no look at which side it is on.
    const double distanceA = solidA_->tree.nearest(center).distance;
    if (!mayBeDeeper(distanceA - lessA)) return;
    const double distanceB = solidB_->tree.nearest(center).distance;
    if (!mayBeDeeper(distanceB - lessB)) return;
    box.inA = depthOf(center, distanceA, solidA_->winding, most + lessA, from.inA, away);
    if (!mayBeDeeper(box.inA.value - lessA)) return;
    box.inB = depthOf(center, distanceB, solidB_->winding, most + lessB, from.inB, away);
    const double here = std::min(box.inA.value - lessA, box.inB.value - lessB);
    most = std::max(most, here);
    box.mostInIt = std::min(here + radius, box.mostInPart);
    boxes.push(box);
  };
  for (const CommonPart& part : parts_) {
    const auto& [low, high] = part.bounds;
    add((low + high) / 2, (high - low) / 2, {.mostInPart = mostIn(part) - saved}, 0);
  }
  for (int count = 0; count < kMostBoxes && !boxes.empty(); count += 2) {
    if (!(boxes.top().mostInIt > kEnough * most) || (any && most > least)) break;
    const Box box = boxes.top();
    boxes.pop();
    // Halved along its longest side.
    int axis = 0;
    Point3 half = box.half;
    half.maxCoeff(&axis);
    half[axis] /= 2;
    const Point3 by = half[axis] * Point3::Unit(axis);
    add(box.center - by, half, box, half[axis]);
    add(box.center + by, half, box, half[axis]);
  }
  return most > least ? most : 0;
}

}  // namespace t4d::measure
