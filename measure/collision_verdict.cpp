#include "measure/collision_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "measure/overlap_depth.h"
#include "t4d/slice.h"

namespace t4d::measure {
namespace {

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

/// Steps for which the bounds of both together are at most `length`, as what decides a verdict.
template <class Verdict>
void setSteps(Verdict& verdict, const ChordBound& a, const ChordBound& b, double length) {
  if (!a.isStated && !b.isStated) verdict.minVolumeRatio = ratioFor(a, b, length);
  const int moving = (a.bound > a.rounding ? 1 : 0) + (b.bound > b.rounding ? 1 : 0);
  if (moving > 0) verdict.maxDeviation = length / moving;
}

}  // namespace

Result<CollisionVerdict> verdictOn(const Collision& collision, const model::Source& a,
                                   const model::Source& b,
                                   const std::array<MotionBetweenLayers, 2>& motions) {
  if (!collision.common) return CollisionVerdict();
  const auto boundA = chordBound(a, *collision.common, motions[0]);
  if (!boundA) return boundA.error();
  const auto boundB = chordBound(b, *collision.common, motions[1]);
  if (!boundB) return boundB.error();
  return verdictWith({*boundA, *boundB}, collision, a, b);
}

Result<CollisionVerdict> verdictWith(const ChordBounds& bounds, const Collision& collision,
                                     const model::Source& a, const model::Source& b) {
  CollisionVerdict result;
  if (!collision.common) return result;
  result.chordsA = bounds[0];
  result.chordsB = bounds[1];
  const ChordBound chordsA = bounds[0].value_or(ChordBound{});
  const ChordBound chordsB = bounds[1].value_or(ChordBound{});
  const double bound = result.knownBound();
  if (bounds[0] && bounds[1]) result.chordBound = bound;

  const slice::TimeSlicer slicesOfA(a);
  const slice::TimeSlicer slicesOfB(b);
  bool certain = false;
  for (const ContactInterval& interval : collision.intervals) {
    if (!interval.overlaps) continue;
    const auto sliceA = slicesOfA.at(interval.deepestTime);
    if (!sliceA) return sliceA.error();
    const auto sliceB = slicesOfB.at(interval.deepestTime);
    if (!sliceB) return sliceB.error();
    if (sliceA->mesh.triangles.empty() || sliceB->mesh.triangles.empty()) continue;
    const OverlapDepth depth(sliceA->mesh, sliceB->mesh);
    certain = certain || depth.greatest(chordsA.bound, chordsB.bound, /*any=*/true) > 0;
    result.depth = std::max(result.depth, depth.greatest(0, 0, /*any=*/false, result.depth));
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
    setSteps(result, chordsA, chordsB, share);
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
      setSteps(result, verdict.chordsA.value_or(ChordBound{}),
               verdict.chordsB.value_or(ChordBound{}), margin / 2);
    }
  } else {
    result.minVolumeRatio = verdict.minVolumeRatio;
    result.maxDeviation = verdict.maxDeviation;
  }
  return result;
}

}  // namespace t4d::measure
