#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "t4d/formats/animation/curve_bound.h"
#include "t4d/formats/usd/usd_text.h"
#include "t4d/model/motion.h"

namespace t4d::formats {

/// An xformOp of a prim (UsdGeomXformOp): a function of time, constant before its first sample and
/// after its last one.
class UsdXformOp {
 public:
  /// `name` is that in xformOpOrder, with `!invert!` before it or not. Times become seconds. Fails
  /// on ops that are not known, without a value, or with numbers that are not finite, and on what
  /// is inverted, animated and no rotation or translation.
  static Result<UsdXformOp> read(const UsdDocument& document, const UsdPrim& prim,
                                 const std::string& name, double timeCodesPerSecond);

  /// A scale that is the same at all times and along all axes.
  static UsdXformOp scaling(double factor);

  const std::vector<double>& times() const { return times_; }
  bool moves() const { return times_.size() > 1; }
  /// The time codes of the first and the last sample.
  double firstCode() const { return firstCode_; }
  double lastCode() const { return lastCode_; }
  Eigen::Affine3d at(double time) const;
  /// Of the place of a point that moves within its coordinates, over an interval without samples
  /// inside.
  CurveBound bound(const CurveBound& point, double begin, double end) const;
  /// Rotations between samples that slerp could take either way round.
  std::vector<model::HalfTurn> halfTurns() const;

 private:
  enum class Kind { Translate, Scale, Rotate, Orient, Matrix };

  Eigen::VectorXd valueAt(double time) const;
  CurveBound linearBound(double begin, double end) const;

  Kind kind_ = Kind::Translate;
  std::string axes_;  // of Rotate, in the order in which they turn
  bool inverted_ = false;
  double firstCode_ = 0;
  double lastCode_ = 0;
  std::vector<double> times_;
  std::vector<Eigen::VectorXd> values_;  // a translation or scale, degrees, w x y z, or rows
};

/// The ops of a prim, the outermost first.
struct UsdXform {
  std::vector<UsdXformOp> ops = {};
  bool resets = false;  ///< parents do not move it

  /// Fails as UsdXformOp::read, and for more ops than a prim has.
  static Result<UsdXform> read(const UsdDocument& document, const UsdPrim& prim,
                               double timeCodesPerSecond);
};

}  // namespace t4d::formats
