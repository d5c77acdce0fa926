#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "formats/toolpath/gcode_arc.h"
#include "formats/toolpath/rotary_kinematics.h"
#include "t4d/error.h"

namespace t4d::formats {

/// A move of which the end may still change.
struct CompensatedMove {
  MachineAxes to = {};
  bool rapid = false;
  double feed = 0;                                      ///< mm/min
  std::optional<Arc> arc = {};                          ///< in the plane
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< of a straight move, as programmed
  bool isCorner = false;                                ///< an arc about a corner, whose end stays
};

/// The path of the centre of a cutter (G41, G42), a radius to the left or right of the programmed
/// one, as LinuxCNC makes it: the first move ends beside its own end; at an outer corner the cutter
/// goes in an arc about it; at an inner corner the moves are cut off where their paths meet. A
/// move is held back until the one after it is known. Fails where an inner corner is too narrow
/// for the cutter.
class CutterCompensation {
 public:
  using Emit = std::function<Result<void>(const CompensatedMove&)>;

  /// In this plane, from there on.
  CutterCompensation(std::array<int, 3> plane, bool left, double radius, const MachineAxes& at,
                     Emit emit);

  Result<void> straight(const MachineAxes& to, bool rapid, double feed);
  /// `words` are those of the programmed path.
  Result<void> arc(const ArcWords& words, const MachineAxes& to, double feed);
  /// The last move ends beside its end.
  Result<void> end();

 private:
  Eigen::Vector2d flat(const MachineAxes& at) const;
  MachineAxes at(const Eigen::Vector2d& flat, const MachineAxes& others) const;
  bool isInside(double radians) const { return (radians > 0) == left_; }
  double side() const { return left_ ? 1 : -1; }

  void begin(const MachineAxes& to, bool rapid, double feed);
  Result<void> beginArc(const Arc& arc, const MachineAxes& to, double feed);
  Result<void> release();
  Result<void> cutOff(const Eigen::Vector2d& end);
  Result<Eigen::Vector2d> cornerAfterArc(const Arc& before, const Eigen::Vector2d& to) const;
  Result<Eigen::Vector2d> cornerBeforeArc(const Arc& next, double theta, double beta) const;
  Result<Eigen::Vector2d> cornerOfArcs(const Arc& before, const Arc& next) const;
  Result<void> goAround(const Eigen::Vector2d& end, double feed, bool rapid);
  double radiusOf(const Arc& arc) const;

  std::array<int, 3> plane_;
  bool left_;
  double radius_;
  Emit emit_;
  std::vector<CompensatedMove> held_;
  bool isFirst_ = true;
  MachineAxes programmed_;  // where the programmed path is
  Eigen::Vector2d beside_;  // the centre of the cutter there
  Eigen::Vector2d placed_;  // where the last move that was released ended
};

}  // namespace t4d::formats
