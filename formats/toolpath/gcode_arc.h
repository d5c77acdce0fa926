#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "t4d/error.h"

namespace t4d::formats {

/// An arc in its plane, in mm, as the words of a line give it.
struct ArcWords {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  bool clockwise = false;
  std::optional<Eigen::Vector2d> centre = {};
  std::optional<double> radius = {};  ///< negative: the longer way round
  double turns = 1;                   ///< P
  double unit = 1;                    ///< mm; that of the program, whose digits are rounded
};

/// A circle, or a part of a spiral that is one but for the rounding of its words.
struct Arc {
  Eigen::Vector2d centre;
  Eigen::Vector2d begin;  ///< from the centre
  double endRadius = 0;
  double radians = 0;  ///< positive counter-clockwise

  double length() const { return begin.norm() * std::abs(radians); }
  Eigen::Vector2d at(double part) const;
};

/// Fails if neither or both of centre and radius are given, or if they do not fit the ends, which
/// has the tolerance of LinuxCNC.
Result<Arc> arcOf(const ArcWords& words);

/// The number of chords with which an arc stays within the tolerance. Fails for more than a motion
/// can have.
Result<std::uint64_t> chordsOfArc(const Arc& arc, double tolerance);

}  // namespace t4d::formats
