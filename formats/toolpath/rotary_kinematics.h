#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// X, Y, Z in mm and A, B, C in degrees.
using MachineAxes = std::array<double, 6>;

/// A rotary axis of a machine: A turns about x, B about y and C about z.
struct RotaryAxis {
  int axis = 3;          ///< in MachineAxes
  bool onTable = true;   ///< turns the table, or else the head
  double direction = 1;  ///< -1: the other way round than ISO 841 has it
  /// A point of the axis. Of a table: in the stock's frame, where the table is at zero. Of a head:
  /// from the control point, where the head is at zero.
  model::Point3 point = model::Point3::Zero();
};

/// Reads `A=table:0,0,-50`, `B=head:0,0,150` or `C=table`, with -table and -head for the other way
/// round.
Result<RotaryAxis> parseRotaryAxis(std::string_view text);

/// A tool against the stock: its tip, and the direction from there to the shank.
struct ToolPlace {
  model::Point3 tip;
  Eigen::Vector3d axis;
};

/// Rotary axes of a machine, in the order in which they carry each other: those of the table from
/// its base to the stock, those of the head from its base to the tool. Positive angles turn the
/// tool against the stock right-handed (ISO 841), whichever of them moves.
class RotaryKinematics {
 public:
  explicit RotaryKinematics(std::vector<RotaryAxis> axes) : axes_(std::move(axes)) {}

  bool turns(int axis) const;

  /// Of a tool with its tip `length` below the control point.
  ToolPlace toolAt(const MachineAxes& at, const Eigen::Vector3d& length) const;
  /// The position with these angles at which the tip is there.
  MachineAxes positionOf(const model::Point3& tip, const MachineAxes& angles,
                         const Eigen::Vector3d& length) const;

  /// The number of straight parts of a move that goes evenly in all axes, so that tip and all
  /// points within `reach` of it stay within the tolerance of their paths.
  double partsOf(const MachineAxes& from, const MachineAxes& to, const Eigen::Vector3d& length,
                 double reach, double tolerance) const;

 private:
  Eigen::Matrix3d rotationOf(const RotaryAxis& axis, const MachineAxes& at) const;

  std::vector<RotaryAxis> axes_;
};

}  // namespace t4d::formats
