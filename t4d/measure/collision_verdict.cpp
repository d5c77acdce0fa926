#include "t4d/measure/collision_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "t4d/convert/slice.h"
#include "t4d/measure/triangle_tree.h"
#include "t4d/measure/winding_number.h"

namespace t4d::measure {
namespace {

using model::Point3;

/// How deep points lie in both of two solids.
class Depth {
 public:
  Depth(const model::TriangleMesh& a, const model::TriangleMesh& b)
      : treeA_(a), treeB_(b), windingA_(a), windingB_(b) {}

  /// The lesser of the depths in the two solids, less a length for each; nothing if it is not more
  /// than `most`.
  std::optional<double> moreThan(double most, const Point3& point, double lessA,
                                 double lessB) const {
    const double depth =
        std::min(treeA_.nearest(point).distance - lessA, treeB_.nearest(point).distance - lessB);
    if (depth > most && isInside(windingA_, point) && isInside(windingB_, point)) return depth;
    return std::nullopt;
  }

 private:
  static bool isInside(const WindingNumber& winding, const Point3& point) {
    constexpr double kSure = 0.25;  // far more than `at` is off
    const double number = winding.at(point) - 0.5;
    return (std::abs(number) > kSure ? number : winding.exactAt(point) - 0.5) > 0;
  }

  TriangleTree treeA_;
  TriangleTree treeB_;
  WindingNumber windingA_;
  WindingNumber windingB_;
};

/// The greatest depth, less a length for each solid, that a lattice and a search from its best
/// points find; 0 if none is positive.
double greatestDepth(const Depth& depth, const model::Bounds3& bounds, double lessA, double lessB) {
  constexpr int kPoints = 9;  // along each axis
  constexpr double kFinest = 1.0 / 256;
  const Point3 size = bounds.max - bounds.min;
  Point3 best = bounds.min + size / 2;
  double most = 0;
  const auto consider = [&](const Point3& point) {
    const auto found = depth.moreThan(most, point, lessA, lessB);
    if (!found) return false;
    most = *found;
    best = point;
    return true;
  };
  consider(best);
  for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
    const Point3 at((i % kPoints + 0.5) / kPoints, (i / kPoints % kPoints + 0.5) / kPoints,
                    (i / kPoints / kPoints + 0.5) / kPoints);
    consider(bounds.min + at.cwiseProduct(size));
  }
  if (most == 0) return 0;
  for (double step = 0.5 / kPoints; step > kFinest;) {
    bool moved = false;
    for (int k = 0; k < 6; ++k) {
      const Point3 by = size.cwiseProduct(Point3::Unit(k / 2)) * (k % 2 == 0 ? step : -step);
      moved = consider(best + by) || moved;
    }
    if (!moved) step /= 2;
  }
  return most;
}

/// The largest steps for which the bounds of both are below `length`.
std::optional<double> ratioFor(const ChordBound& a, const ChordBound& b, double length) {
  const auto bound = [&](double angle) {
    return a.forAngle(std::min(angle, a.angleRadians)) +
           b.forAngle(std::min(angle, b.angleRadians));
  };
  double low = 0;
  double high = std::max(a.angleRadians, b.angleRadians);
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (bound(middle) < length ? low : high) = middle;
  }
  const double ratio = (1 + std::cos(low)) / 2;
  return ratio < 1 ? std::optional(ratio) : std::nullopt;
}

}  // namespace

Result<CollisionVerdict> verdictOn(const Collision& collision, const model::Source& a,
                                   const model::Source& b) {
  CollisionVerdict result;
  if (!collision.common) return result;
  const auto boundA = chordBound(a, *collision.common);
  if (!boundA) return pass(boundA.error());
  const auto boundB = chordBound(b, *collision.common);
  if (!boundB) return pass(boundB.error());
  const ChordBound chordsA = boundA->value_or(ChordBound{});
  const ChordBound chordsB = boundB->value_or(ChordBound{});
  const double bound = chordsA.bound + chordsB.bound;
  if (*boundA && *boundB) result.chordBound = bound;

  const convert::TimeSlicer slicesOfA(a);
  const convert::TimeSlicer slicesOfB(b);
  bool overlaps = false;
  bool certain = false;
  for (const ContactInterval& interval : collision.intervals) {
    if (!interval.overlaps) continue;
    overlaps = true;
    const auto sliceA = slicesOfA.at(interval.deepestTime);
    if (!sliceA) return pass(sliceA.error());
    const auto sliceB = slicesOfB.at(interval.deepestTime);
    if (!sliceB) return pass(sliceB.error());
    if (sliceA->mesh.triangles.empty() || sliceB->mesh.triangles.empty()) continue;
    model::Bounds3 common = boundsOf(sliceA->mesh);
    const model::Bounds3 other = boundsOf(sliceB->mesh);
    common.min = common.min.cwiseMax(other.min);
    common.max = common.max.cwiseMin(other.max);
    if (common.empty()) continue;
    const Depth depth(sliceA->mesh, sliceB->mesh);
    certain = certain || greatestDepth(depth, common, chordsA.bound, chordsB.bound) > 0;
    result.depth = std::max(result.depth, greatestDepth(depth, common, 0, 0));
  }
  double margin = result.depth;
  if (collision.contact()) {
    if (bound == 0) {
      result.verdict = overlaps ? Verdict::Hit : Verdict::Touch;
    } else {
      result.verdict = certain ? Verdict::Hit : Verdict::WithinTolerance;
    }
  } else if (collision.clearance) {
    margin = collision.clearance->lowerBound;
    result.clearBy = std::max(0.0, margin - bound);
    result.verdict = margin > bound ? Verdict::Clear : Verdict::WithinTolerance;
  }
  if (result.verdict == Verdict::WithinTolerance && margin > 0) {
    // Finer meshes may be nearer by their own bound, and must still be apart by more than that.
    result.minVolumeRatio = ratioFor(chordsA, chordsB, margin / 2);
  }
  return result;
}

}  // namespace t4d::measure
