#pragma once

/// Motions of a solid: rigidly, by screws, or by the positions of its vertices at keys.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "t4d/error.h"
#include "t4d/mesh.h"

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

/// A motion given as a function of time: its poses at `times`, joined as joinPoses does. Fails if
/// joinPoses does, and for a rotation whose matrix is not one (to 1e-6).
Result<Motion> sampledMotion(const std::function<Pose(double time)>& pose,
                             std::span<const double> times);

/// The positions of the vertices of a triangle mesh at a sequence of times, the keys. Between two
/// keys every vertex moves along a straight line at constant speed.
class VertexKeys {
 public:
  virtual ~VertexKeys() = default;

  /// The number of keys, at least two.
  virtual std::uint64_t count() const = 0;
  /// The time of a key; increases from key to key.
  virtual double time(std::uint64_t key) const = 0;
  /// The affine map that takes the vertices of the mesh to their positions at this key; nothing if
  /// there is none. With such maps a 4D mesh takes less space in a file.
  virtual std::optional<Affine3x4> pose(std::uint64_t /*key*/) const { return std::nullopt; }
  /// The positions of all vertices at this key, in the order of the mesh. If there is a pose, they
  /// are those of `posed`. Keys may be requested in any order; ascending order is the fastest.
  virtual Result<void> positions(std::uint64_t key, std::span<Point3> into) const = 0;
};

/// Keys in memory.
class StoredKeys : public VertexKeys {
 public:
  struct Key {
    double time = 0;
    std::vector<Point3> positions = {};
  };
  explicit StoredKeys(std::vector<Key> keys) : keys_(std::move(keys)) {}

  std::uint64_t count() const override { return keys_.size(); }
  double time(std::uint64_t key) const override { return keys_[key].time; }
  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    std::copy(keys_[key].positions.begin(), keys_[key].positions.end(), into.begin());
    return {};
  }

 private:
  std::vector<Key> keys_;
};

/// Keys that are a function of time: a mesh that is computed, not stored.
class FunctionKeys : public VertexKeys {
 public:
  /// Sets the positions of all vertices, in the order of the mesh, at a time.
  using Positions = std::function<void(double time, std::span<Point3> into)>;

  FunctionKeys(std::vector<double> times, Positions positions)
      : times_(std::move(times)), positions_(std::move(positions)) {}

  std::uint64_t count() const override { return times_.size(); }
  double time(std::uint64_t key) const override { return times_[key]; }
  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    positions_(times_[key], into);
    return {};
  }

 private:
  std::vector<double> times_;
  Positions positions_;
};

}  // namespace t4d::model

namespace t4d::formats {

/// Properties of a table of poses that the names of its columns may leave open.
struct MotionTableOptions {
  /// The kind and unit of angles: "rpy:deg", "rpy:rad", "rotvec:deg" or "rotvec:rad"; "" if names
  /// say it.
  std::string angles = {};
  /// The order of the four numbers of a quaternion: "xyzw" or "wxyz"; "" if names say it.
  std::string quaternion = {};
  /// The units of positions and times. Columns that name another unit are converted to these.
  std::string lengthUnit = {};
  std::string timeUnit = {};

  bool empty() const {
    return angles.empty() && quaternion.empty() && lengthUnit.empty() && timeUnit.empty();
  }
};

/// Reads a motion file (docs/motion.md; JSON Schema in formats/motion/motion.schema.json):
/// `segments`, each a screw, or `poses`, joined by screws. Refuses, with the file and the place in
/// it, text that is not JSON, unknown keys, missing keys, values of the wrong kind, and what
/// chainScrews or joinPoses refuse. A .csv, .tsv or .txt file is a table of poses (docs/motion.md),
/// which sets `form`; `table` is for these only.
Result<model::Motion> readMotion(const std::filesystem::path& path, std::string* form = nullptr,
                                 const MotionTableOptions& table = {});

/// Parses the text of a JSON motion file; errors name the file `name`.
Result<model::Motion> parseMotion(const std::string& text, const Place& name);

}  // namespace t4d::formats
