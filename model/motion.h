#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "model/error.h"
#include "model/geometry.h"
#include "model/layer_pose.h"
#include "model/times.h"

namespace t4d::model {

/// A rigid placement: p -> rotation * p + translation.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Affine3x4 matrix() const { return (Affine3x4() << rotation, translation).finished(); }
  Point3 operator()(const Point3& point) const { return posed(matrix(), point); }
  /// `(a * b)(p)` is `a(b(p))`.
  friend Pose operator*(const Pose& a, const Pose& b) {
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
  }
};

/// A screw motion: a rotation about an axis combined with a translation, both uniform. Rests and
/// pure translations are screws with angle 0.
struct Screw {
  Point3 axisPoint = Point3::Zero();
  Eigen::Vector3d axisDirection = Eigen::Vector3d::UnitZ();  ///< of length 1
  double angleDegrees = 0;  ///< right-handed about the axis; any number of turns
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< in total; in any direction

  /// The pose after a fraction of the motion, in closed form, so errors do not accumulate. Angles
  /// are reduced in degrees: whole turns and quarter turns are exact.
  Pose at(double fraction) const;
};

/// One uniform screw of a motion.
struct Segment {
  double timeBegin = 0;
  double timeEnd = 0;
  Pose start = {};   ///< from the input mesh to the start of this segment
  Pose end = {};     ///< the next segment's `start`
  Screw screw = {};  ///< in world coordinates, applied after `start`

  /// The pose at a fraction of the segment: exactly `start` at 0 and `end` at 1.
  Pose at(double fraction) const;
};

/// Two poses that are half a turn apart, up to the rounding of tables. Both ways round are equally
/// short, so the poses do not determine the direction of the turn.
struct HalfTurn {
  std::size_t pose = 0;  ///< the first of the two, counted from 0
  TimeSpan time = {};
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the turn taken, which is right-handed
  std::string between = {};  ///< the two poses in the numbering of their file, "lines 3 and 4"
};

/// Rotations by at least this angle count as half turns. Quaternions with three decimals are off by
/// as much.
inline constexpr double kHalfTurnDegrees = 179.8;

/// A sentence for the user about turns whose direction is unknown; empty if there are none.
std::string noticeOfHalfTurns(std::span<const HalfTurn> turns);

/// A rigid motion: a sequence of screws without gaps.
struct Motion {
  std::vector<Segment> segments = {};    ///< at least one
  std::vector<HalfTurn> halfTurns = {};  ///< between poses; the segments have the directions taken
  std::string lengthUnit = {};           ///< "" if unknown
  std::string timeUnit = {};

  double timeBegin() const { return segments.front().timeBegin; }
  double timeEnd() const { return segments.back().timeEnd; }
  /// The pose at a time within the motion; times outside are clamped.
  Pose at(double time) const;
};

/// The maximum number of segments; more would not fit in memory.
inline constexpr std::uint64_t kMaxSegments = 1'000'000;

/// `count` equal screws in sequence, each in world coordinates.
struct ScrewRun {
  double duration = 0;  ///< of one screw; positive
  Screw screw = {};
  std::uint64_t count = 1;
};

/// Chains screws starting at `startTime`; the first starts with the input mesh unmoved. Times are
/// exact sums of decimals (times.h). Fails if there are no runs, and for a duration that is not
/// positive or too short to represent, a rotation about an axis of length zero, and numbers that
/// are not finite.
Result<Motion> chainScrews(double startTime, std::span<const ScrewRun> runs);

/// A placement at a time: p -> quaternion p quaternion^-1 + position.
struct KeyPose {
  double time = 0;
  Point3 position = Point3::Zero();
  Eigen::Quaterniond quaternion = Eigen::Quaterniond::Identity();
};

/// Joins consecutive poses by the unique screw of at most half a turn (Chasles' theorem), whose
/// translation is along its axis, and lists half turns. Fails for fewer than two poses, times that
/// do not increase, and quaternions that are not of unit length (to 1e-6).
Result<Motion> joinPoses(std::span<const KeyPose> poses);

}  // namespace t4d::model
