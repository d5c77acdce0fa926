#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"

namespace t4d::model {

/// A part of a mechanism that moves relative to its parent, or to the world.
struct Link {
  static constexpr std::size_t kWorld = ~std::size_t{0};

  std::string name = {};
  std::size_t parent = kWorld;  ///< number of a link before this one
  /// The motion from its place at rest, in the coordinates of the world while everything is at
  /// rest; nothing if the link is fixed to its parent. Outside its times it has its first or last
  /// pose.
  std::optional<Motion> motion = {};
};

/// Links that move each other: a tree, or several. The pose of a link is the product of the motions
/// from the root to it, each about its axis as it is at rest (product of exponentials, Brockett
/// 1984): with all joints at rest it is the identity.
struct Mechanism {
  std::vector<Link> links;

  Pose at(std::size_t link, double time) const;
  /// Whether the link or one that it is attached to has a motion.
  bool moves(std::size_t link) const;
  /// The span from the first time of all motions to the last; nothing if nothing moves.
  std::optional<TimeSpan> span() const;
  /// Times at which a motion that moves the link changes, in order.
  std::vector<double> knots(std::size_t link) const;
};

/// A joint with one value: its axis, with all joints at rest.
struct Joint {
  enum class Type : std::uint8_t { Revolute, Prismatic, Screw };

  Type type = Type::Revolute;
  Point3 origin = Point3::Zero();                   ///< a point on the axis
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of length 1
  double pitch = 0;                                 ///< of Screw: length units for each turn
};

/// The motion of a joint whose value goes evenly from each of `values` to the next: degrees,
/// right-handed about the axis, or length units along it for Prismatic. Fails for fewer than two
/// values, times that do not increase, and numbers that are not finite or beyond limits; `where` of
/// the error is the number of the value.
Result<Motion> jointMotion(const Joint& joint, std::span<const double> times,
                           std::span<const double> values);

/// Within [begin, end], in which no motion of the chain changes: a bound of the acceleration of a
/// point that is at `place` in the world when everything is at rest, and moves with the link.
double accelerationBound(const Mechanism& mechanism, std::size_t link, const Point3& place,
                         const TimeSpan& span);

/// The angle in degrees that a link turns by within a span at most, the sum of its joints.
double turnBound(const Mechanism& mechanism, std::size_t link, const TimeSpan& span);

}  // namespace t4d::model
