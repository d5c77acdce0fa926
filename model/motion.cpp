#include "t4d/motion.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "model/degrees.h"
#include "model/limits.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
SinCos sinCosDegrees(double degrees) {
  const double reduced = std::remainder(degrees, 360.0);  // exact, within [-180, 180]
  const double quarter = std::nearbyint(reduced / 90.0);  // -2 .. 2
  const double radians = (reduced - quarter * 90.0) * kRadiansPerDegree;
  const double s = std::sin(radians);
  const double c = std::cos(radians);
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// R - 1 for a rotation R about a unit vector (Rodrigues' formula), to full relative precision also
/// at small angles, since it is multiplied by the distance of the axis.
Eigen::Matrix3d rotationMinusOne(const Eigen::Vector3d& axis, double degrees) {
  const auto [s, c] = sinCosDegrees(degrees);
  const double halfSine = sinCosDegrees(degrees / 2).sin;
  const double versine = c < 0.5 ? 1 - c : 2 * halfSine * halfSine;
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return s * cross + versine * (cross * cross);
}

bool isFinite(const Screw& screw) {
  return screw.axisPoint.allFinite() && screw.axisDirection.allFinite() &&
         std::isfinite(screw.angleDegrees) && screw.translation.allFinite();
}

Result<void> checkMagnitude(const char* what, double magnitude, const Place& where) {
  if (magnitude <= kLargestCoordinate) return {};
  return invalid(fmt::format("has {} of magnitude {:.3g}; the largest possible is {}", what,
                             magnitude, kLargestCoordinate),
                 where);
}

/// Checks that every number is within the limits of coordinates and times.
Result<void> checkMagnitudes(const Screw& screw, double duration, const Place& where) {
  auto checked = checkMagnitude("an axis_point", screw.axisPoint.cwiseAbs().maxCoeff(), where);
  if (checked) {
    checked = checkMagnitude("a translation", screw.translation.cwiseAbs().maxCoeff(), where);
  }
  if (checked) checked = checkMagnitude("a duration", duration, where);
  return checked;
}

}  // namespace

Pose Screw::at(double fraction) const {
  Pose pose;
  const Eigen::Matrix3d turn = rotationMinusOne(axisDirection, angleDegrees * fraction);
  pose.rotation += turn;
  pose.translation = fraction * translation - turn * axisPoint;
  return pose;
}

Pose Segment::at(double fraction) const {
  if (fraction <= 0) return start;
  if (fraction >= 1) return end;
  return screw.at(fraction) * start;
}

Pose Motion::at(double time) const {
  const auto after =
      std::upper_bound(segments.begin(), segments.end(), time,
                       [](double t, const Segment& segment) { return t < segment.timeEnd; });
  if (after == segments.end()) return segments.back().end;
  return after->at((time - after->timeBegin) / (after->timeEnd - after->timeBegin));
}

Result<Motion> chainScrews(double startTime, std::span<const ScrewRun> runs) {
  if (runs.empty()) return invalid("the motion has no segment; give at least one");
  if (!std::isfinite(startTime)) return invalid("the start time is not a finite number");
  if (auto good = checkMagnitude("a start time", std::abs(startTime), {}); !good) {
    return invalid("the motion " + good.error().message);
  }
  Motion motion;
  double runBegin = startTime;
  Pose pose;
  for (std::size_t index = 0; index < runs.size(); ++index) {
    const auto& [duration, givenScrew, count] = runs[index];
    const auto where = [&] {
      return placeIn({}, fmt::format("segment {} (counted from 0)", index));
    };
    Screw screw = givenScrew;
    if (!isFinite(screw)) return invalid("has a number that is not finite", where());
    if (!(duration > 0) || !std::isfinite(duration)) {
      return invalid(fmt::format("lasts {}: a duration must be positive; a 4D mesh cannot go "
                                 "backward through time or stand still in it",
                                 duration),
                     where());
    }
    if (auto good = checkMagnitudes(screw, duration, where()); !good) return good.error();
    const double length = screw.axisDirection.stableNorm();
    if (length > 0 && std::isfinite(length)) {
      screw.axisDirection /= length;
    } else if (screw.angleDegrees != 0) {
      return invalid(fmt::format("turns by {} degrees about an axis_direction of length {}; give "
                                 "a direction that is not zero",
                                 screw.angleDegrees, length),
                     where());
    } else {
      screw.axisDirection = Eigen::Vector3d::UnitZ();
    }
    if (count == 0) return invalid("repeats 0 times; once is the least", where());
    if (count > kMaxSegments - motion.segments.size()) {
      return invalid(fmt::format("repeats {} times, after {} segments before it; a motion has at "
                                 "most {} in total",
                                 count, motion.segments.size(), kMaxSegments),
                     where());
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      Segment segment;
      segment.timeBegin = i == 0 ? runBegin : motion.segments.back().timeEnd;
      segment.timeEnd = steppedTime(runBegin, duration, i + 1);
      if (!(segment.timeEnd > segment.timeBegin) || !std::isfinite(segment.timeEnd)) {
        return invalid(fmt::format("lasts {}, which is too short to represent at time {}: doubles "
                                   "there are {:.3g} apart",
                                   duration, segment.timeBegin,
                                   std::nextafter(std::abs(segment.timeBegin), HUGE_VAL) -
                                       std::abs(segment.timeBegin)),
                       where());
      }
      if (auto good = checkMagnitude("an end time", segment.timeEnd, where()); !good) {
        return good.error();
      }
      segment.screw = screw;
      segment.start = pose;
      pose = screw.at(1) * pose;
      segment.end = pose;
      motion.segments.push_back(segment);
    }
    runBegin = motion.segments.back().timeEnd;
  }
  return motion;
}

namespace {

/// The screw of smallest angle that moves `from` to `to` (Chasles), with its translation along its
/// axis.
Screw screwBetween(const Pose& from, const Pose& to) {
  const Eigen::Matrix3d rotation = to.rotation * from.rotation.transpose();
  const Eigen::Vector3d shift = to.translation - rotation * from.translation;
  Screw screw;
  const Eigen::AngleAxisd angleAxis(Eigen::Quaterniond(rotation).normalized());
  const double degrees = angleAxis.angle() * kDegreesPerRadian;
  // Below this a rotation is rounding noise of the quaternions, and its axis is meaningless.
  constexpr double kNoRotationDegrees = 1e-12;
  if (degrees < kNoRotationDegrees) {
    screw.translation = shift;
    return screw;
  }
  screw.angleDegrees = degrees;
  screw.axisDirection = angleAxis.axis();
  screw.translation = screw.axisDirection.dot(shift) * screw.axisDirection;
  // The axis point c nearest the origin solves (1 - R) c = shift across the axis.
  const Eigen::Vector3d across = shift - screw.translation;
  const double halfAngle = 0.5 * angleAxis.angle();
  screw.axisPoint = 0.5 * (across + screw.axisDirection.cross(across) / std::tan(halfAngle));
  return screw;
}

}  // namespace

Result<Motion> joinPoses(std::span<const KeyPose> poses) {
  if (poses.size() < 2) {
    return invalid(fmt::format("the motion has {} poses; at least two are needed", poses.size()));
  }
  if (poses.size() - 1 > kMaxSegments) {
    return invalid(fmt::format("the motion has {} poses; at most {} are accepted", poses.size(),
                               kMaxSegments + 1));
  }
  constexpr double kUnitLengthTolerance = 1e-6;
  std::vector<Pose> placements;
  placements.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto where = [&] { return placeIn({}, fmt::format("pose {} (counted from 0)", i)); };
    const KeyPose& pose = poses[i];
    const double norm = pose.quaternion.norm();
    if (!std::isfinite(pose.time) || !pose.position.allFinite() || !std::isfinite(norm)) {
      return invalid("has a number that is not finite", where());
    }
    if (std::abs(norm - 1) > kUnitLengthTolerance) {
      return invalid(fmt::format("has a quaternion of length {}, not 1", norm), where());
    }
    auto good = checkMagnitude("a time", std::abs(pose.time), where());
    if (good) {
      good = checkMagnitude("a position", pose.position.cwiseAbs().maxCoeff(), where());
    }
    if (!good) return good.error();
    if (i > 0 && !(pose.time > poses[i - 1].time)) {
      return invalid(fmt::format("is at time {}, not after the pose before it, at {}: a 4D mesh "
                                 "cannot go backward through time",
                                 pose.time, poses[i - 1].time),
                     where());
    }
    placements.push_back({pose.quaternion.normalized().toRotationMatrix(), pose.position});
  }
  Motion motion;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    Segment segment;
    segment.timeBegin = poses[i].time;
    segment.timeEnd = poses[i + 1].time;
    segment.start = placements[i];
    segment.end = placements[i + 1];
    segment.screw = screwBetween(segment.start, segment.end);
    if (segment.screw.angleDegrees >= kHalfTurnDegrees) {
      motion.halfTurns.push_back({i,
                                  {segment.timeBegin, segment.timeEnd},
                                  segment.screw.axisDirection,
                                  fmt::format("poses {} and {} (counted from 0)", i, i + 1)});
    }
    motion.segments.push_back(segment);
  }
  return motion;
}

std::string noticeOfHalfTurns(std::span<const HalfTurn> turns) {
  if (turns.empty()) return {};
  const HalfTurn& first = turns.front();
  // Rounding takes away the noise, and adding 0 takes away -0.
  const Eigen::Vector3d axis = (1e4 * first.axis).array().round() / 1e4 + 0.0;
  const std::string where = turns.size() == 1 ? first.between + " are"
                                              : fmt::format("{} pairs of poses, the first {}, are",
                                                            turns.size(), first.between);
  return fmt::format(
      "{} half a turn apart, so the direction of the turn is not known: from time {} to {} it is "
      "taken right-handed about ({}, {}, {}). Add a pose in between to choose it",
      where, first.time.begin, first.time.end, axis.x(), axis.y(), axis.z());
}

Result<Motion> sampledMotion(const std::function<Pose(double time)>& pose,
                             std::span<const double> times) {
  constexpr double kRotationTolerance = 1e-6;
  std::vector<KeyPose> poses;
  poses.reserve(times.size());
  for (const double time : times) {
    const Pose at = pose(time);
    const Eigen::Matrix3d product = at.rotation * at.rotation.transpose();
    if (!((product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRotationTolerance) ||
        at.rotation.determinant() < 0) {
      return invalid("has a matrix that is no rotation",
                     placeIn({}, fmt::format("pose {} (counted from 0)", poses.size())));
    }
    poses.push_back({time, at.translation, Eigen::Quaterniond(at.rotation)});
  }
  return joinPoses(poses);
}

}  // namespace t4d::model
