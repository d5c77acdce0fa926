#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "formats/animation/curve_bound.h"
#include "formats/gltf/gltf_model.h"
#include "t4d/motion.h"

namespace t4d::formats {

/// An animated property of a node (glTF 2.0, appendix C): a function of time, constant before the
/// first key and after the last one. Rotations are quaternions (x, y, z, w) of length 1.
class GltfCurve {
 public:
  enum class Interpolation : std::uint8_t { Step, Linear, CubicSpline };
  /// Truths are 0 for false, and STEP.
  enum class Kind : std::uint8_t { Vector, Rotation, Weights, Truth };
  /// The side of a jump: the value before or behind it.
  enum class Side : std::uint8_t { Before, Behind };

  /// Reads the sampler of a channel; `width` numbers make a value: 3 of a vector, 4 of a
  /// rotation, one for each morph target. Keys may be before time 0. Fails for times that do not
  /// increase, numbers that are not finite, other counts than the times ask for, and quaternions of
  /// length zero.
  static Result<GltfCurve> read(const InputFile& file, const tinygltf::Model& model, int animation,
                                int sampler, Kind kind, int width);

  const std::vector<double>& times() const { return times_; }
  /// The times from 0 on, where animations begin.
  std::span<const double> timesFromZero() const;
  /// The times after 0 at which a STEP curve changes.
  std::vector<double> jumps() const;
  Eigen::VectorXd at(double time, Side side) const;
  /// Keys of a LINEAR rotation that are half a turn apart, the later one after time 0; none for
  /// other curves.
  std::vector<model::HalfTurn> halfTurns() const;

  /// The control points of the curve on [begin, end], which holds no key but at its ends, as
  /// columns: a Bezier curve lies in their hull. Those of its derivatives, too. Not for a LINEAR
  /// rotation.
  struct Hull {
    Eigen::MatrixXd value;
    Eigen::MatrixXd first;
    Eigen::MatrixXd second;
  };
  Hull hull(double begin, double end) const;

  /// The bound of the matrix of a rotation on such an interval; infinite where the interval is too
  /// long to tell that a CUBICSPLINE does not pass through zero.
  CurveBound rotationBound(double begin, double end) const;

 private:
  Eigen::VectorXd value(std::size_t key) const;
  /// The four control points on the whole segment from this key on, of one that is no STEP.
  Eigen::MatrixXd segment(std::size_t key) const;
  /// The key whose segment has the time; before the first key 0, behind the last the last one.
  std::size_t keyAt(double time, Side side) const;

  Interpolation interpolation_ = Interpolation::Linear;
  bool rotation_ = false;
  int width_ = 0;
  std::vector<double> times_;
  std::vector<double> numbers_;  // of CUBICSPLINE: in-tangent, value, out-tangent
};

}  // namespace t4d::formats
