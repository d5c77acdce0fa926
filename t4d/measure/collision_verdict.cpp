#include "t4d/measure/collision_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <vector>

#include "t4d/measure/triangle_tree.h"
#include "t4d/measure/winding_number.h"
#include "t4d/slice/slice.h"

namespace t4d::measure {
namespace {

using model::Point3;

/// How deep points lie in both of two solids.
class Depth {
 public:
  Depth(const model::TriangleMesh& a, const model::TriangleMesh& b)
      : treeA_(a), treeB_(b), windingA_(a), windingB_(b) {}

  /// The lesser of the depths in the two solids, less a length for each; negative outside of one.
  /// Points that are a distance apart have values that differ by that distance at most. A value up
  /// to `most` may be too large, but not larger than that, where it takes long to tell inside from
  /// outside: near a surface.
  double at(const Point3& point, double lessA, double lessB, double most) const {
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

 private:
  TriangleTree treeA_;
  TriangleTree treeB_;
  WindingNumber windingA_;
  WindingNumber windingB_;
};

/// The greatest depth, less a length for each solid, to a fiftieth: by branch and bound over boxes,
/// those that may hold the most first. 0 if none is more than `least`; any that is, if `any`.
double greatestDepth(const Depth& depth, const model::Bounds3& bounds, double lessA, double lessB,
                     double least, bool any = false) {
  constexpr int kMostBoxes = 3'000;
  constexpr double kEnough = 1.02;
  struct Box {
    Point3 center;
    Point3 half;
    double mostInIt = 0;
  };
  const auto isLess = [](const Box& p, const Box& q) { return p.mostInIt < q.mostInIt; };
  std::priority_queue<Box, std::vector<Box>, decltype(isLess)> boxes(isLess);
  double most = least;
  const auto add = [&](const Point3& center, const Point3& half) {
    const double here = depth.at(center, lessA, lessB, most);
    most = std::max(most, here);
    boxes.push({center, half, here + half.norm()});
  };
  add((bounds.min + bounds.max) / 2, (bounds.max - bounds.min) / 2);
  for (int count = 1; count < kMostBoxes && boxes.top().mostInIt > kEnough * most; count += 2) {
    if (any && most > least) break;
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
                                   const model::Source& b, std::array<bool, 2> followPoses) {
  CollisionVerdict result;
  if (!collision.common) return result;
  const auto boundOf = [&](const model::Source& source,
                           bool follows) -> Result<std::optional<ChordBound>> {
    if (!follows) return std::optional<ChordBound>();
    return chordBound(source, *collision.common);
  };
  const auto boundA = boundOf(a, followPoses[0]);
  if (!boundA) return pass(boundA.error());
  const auto boundB = boundOf(b, followPoses[1]);
  if (!boundB) return pass(boundB.error());
  result.chordsA = *boundA;
  result.chordsB = *boundB;
  const ChordBound chordsA = boundA->value_or(ChordBound{});
  const ChordBound chordsB = boundB->value_or(ChordBound{});
  const double bound = result.knownBound();
  if (*boundA && *boundB) result.chordBound = bound;

  const slice::TimeSlicer slicesOfA(a);
  const slice::TimeSlicer slicesOfB(b);
  bool certain = false;
  for (const ContactInterval& interval : collision.intervals) {
    if (!interval.overlaps) continue;
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
    // Faces that are to touch overlap by the rounding of their coordinates.
    constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
    const double rounding =
        kRounding * std::max(common.min.cwiseAbs().maxCoeff(), common.max.cwiseAbs().maxCoeff());
    certain = certain || greatestDepth(depth, common, chordsA.bound, chordsB.bound, rounding,
                                       /*any=*/true) > 0;
    result.depth = std::max(result.depth, greatestDepth(depth, common, 0, 0, rounding));
  }
  double margin = result.depth;
  if (collision.contact()) {
    if (certain) {
      result.verdict = Verdict::Hit;
    } else {
      result.verdict = bound == 0 ? Verdict::Touch : Verdict::WithinTolerance;
    }
  } else if (collision.clearance) {
    margin = collision.clearance->lowerBound;
    result.clearBy = std::max(0.0, margin - bound);
    result.verdict = margin > bound ? Verdict::Clear : Verdict::WithinTolerance;
  }
  // Finer meshes may be nearer by their own bound, and must still be apart by more than that.
  const double share = margin / 2 - chordsA.rounding - chordsB.rounding;
  if (result.verdict == Verdict::WithinTolerance && share > 0) {
    result.minVolumeRatio = ratioFor(chordsA, chordsB, share);
  }
  return result;
}

ClearanceVerdict clearanceVerdict(const Collision& collision, const CollisionVerdict& verdict,
                                  double distance) {
  using Answer = ClearanceVerdict::Answer;
  ClearanceVerdict result;
  if (!collision.common) {
    result.least = result.most = std::numeric_limits<double>::infinity();
    result.answer = Answer::Kept;
    return result;
  }
  if (verdict.verdict == Verdict::Hit) {
    result.answer = Answer::NotKept;
    return result;
  }
  result.least = verdict.clearBy;
  if (verdict.verdict != Verdict::Touch) {
    result.most = (collision.clearance ? collision.clearance->distance : 0) + verdict.knownBound();
  }
  const bool known = collision.clearance || verdict.verdict == Verdict::Touch;
  if (known && result.least >= distance) {
    result.answer = Answer::Kept;
  } else if (result.most < distance) {
    result.answer = Answer::NotKept;
  } else if (collision.clearance) {
    const double margin = std::max(collision.clearance->lowerBound - distance,
                                   distance - collision.clearance->distance);
    if (margin > 0) {
      result.minVolumeRatio = ratioFor(verdict.chordsA.value_or(ChordBound{}),
                                       verdict.chordsB.value_or(ChordBound{}), margin / 2);
    }
  } else {
    result.minVolumeRatio = verdict.minVolumeRatio;
  }
  return result;
}

}  // namespace t4d::measure
