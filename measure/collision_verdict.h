#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "measure/chord_bound.h"
#include "t4d/collide.h"

namespace t4d::measure {

/// Conclusions from 4D meshes about the motions that they were made of.
enum class Verdict : std::uint8_t {
  Hit,  ///< the solids overlap for certain
  /// They touch, and overlap by no more than the rounding of coordinates; only said if the meshes
  /// are exact.
  Touch,
  Clear,            ///< they never meet for certain
  WithinTolerance,  ///< the steps are too coarse to tell
};

struct CollisionVerdict {
  Verdict verdict = Verdict::Clear;
  /// How far the two meshes together can be from the motions; nothing if that is not known of one
  /// of them, which then counts as it is.
  std::optional<double> chordBound;
  std::optional<ChordBound> chordsA = {};
  std::optional<ChordBound> chordsB = {};

  /// The sum of those that are known.
  double knownBound() const {
    return (chordsA ? chordsA->bound : 0) + (chordsB ? chordsB->bound : 0);
  }
  /// For solids that overlap: a lower bound of the largest distance of a point in both from both
  /// surfaces, at the deepest time of an interval.
  double depth = 0;
  /// For Clear: the true solids are apart by at least this at all times.
  double clearBy = 0;
  /// For WithinTolerance: a mesh4d::MinVolumeRatio whose steps make the bound smaller than half the
  /// depth or distance found. They decide the case if that depth or distance is the one of the
  /// motions; if not, the report on the finer mesh gives the next ratio. Nothing if no steps are
  /// fine enough, or if the motion of a body is not a screw from pose to pose.
  std::optional<double> minVolumeRatio;
  /// A mesh4d::MaxDeviation that decides the case, as minVolumeRatio does, for any motion.
  std::optional<double> maxDeviation;
};

/// Whether a distance between the true solids is kept at all times.
struct ClearanceVerdict {
  enum class Answer : std::uint8_t {
    Kept,
    NotKept,
    Unknown,  ///< the steps, or the search for the smallest distance, are too coarse to tell
  };
  Answer answer = Answer::Unknown;
  /// The true solids are apart by at least `least` and, at some time, by at most `most`.
  double least = 0;
  double most = 0;
  /// For Unknown, the same as in CollisionVerdict.
  std::optional<double> minVolumeRatio;
  std::optional<double> maxDeviation;
};

/// Bodies that never exist together keep any distance; those that overlap keep none.
ClearanceVerdict clearanceVerdict(const Collision& collision, const CollisionVerdict& verdict,
                                  double distance);

/// A point of both meshes that is deeper in each than the bound of this is a point of both true
/// solids. Slices the bodies at the deepest time of each interval. `motions` are those of a and of
/// b. Fails if a source does.
Result<CollisionVerdict> verdictOn(const Collision& collision, const model::Source& a,
                                   const model::Source& b,
                                   const std::array<MotionBetweenLayers, 2>& motions = {});

/// The same where the bounds of a and b in Collision::common are known: what chordBound says.
using ChordBounds = std::array<std::optional<ChordBound>, 2>;
Result<CollisionVerdict> verdictWith(const ChordBounds& bounds, const Collision& collision,
                                     const model::Source& a, const model::Source& b);

}  // namespace t4d::measure
