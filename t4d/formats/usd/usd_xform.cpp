#include "t4d/formats/usd/usd_xform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "t4d/formats/text/text_scanner.h"
#include "t4d/model/degrees.h"

namespace t4d::formats {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::string_view kInvert = "!invert!";
constexpr std::string_view kReset = "!resetXformStack!";
constexpr std::string_view kXformOp = "xformOp:";

/// "rotateXYZ" of "xformOp:rotateXYZ:suffix".
std::string_view opType(std::string_view name) {
  name.remove_prefix(kXformOp.size());
  return name.substr(0, name.find(':'));
}

/// The number of an axis in lower case.
int axisOf(char c) { return c - 'x'; }

Vector3d unit(char axis) { return Vector3d::Unit(axisOf(axis)); }

Eigen::Quaterniond quaternionOf(const VectorXd& wxyz) {
  return Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized();
}

/// From rows, which multiply from the left.
Affine3d affineOf(const VectorXd& rows) {
  Affine3d made;
  made.matrix() = Eigen::Map<const Eigen::Matrix4d>(rows.data());
  return made;
}

/// The angle between two rotations, the shorter way.
double angleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b);
}

}  // namespace

Result<UsdXformOp> UsdXformOp::read(const UsdDocument& document, const UsdPrim& prim,
                                    const std::string& name, double timeCodesPerSecond) {
  UsdXformOp op;
  std::string_view plain = name;
  op.inverted_ = plain.starts_with(kInvert);
  if (op.inverted_) plain.remove_prefix(kInvert.size());
  const UsdProperty* property = prim.property(plain);
  const auto refuse = [&](std::string_view what) {
    return invalid(fmt::format("{} of prim '{}' {}", inQuotes(plain), prim.name, what),
                   document.where(property != nullptr ? property->name : prim.name));
  };
  if (!plain.starts_with(kXformOp) || property == nullptr) return refuse("is not there");
  if (property->isSpline) {
    return fail(ErrorCode::Unsupported,
                fmt::format("{} is a spline; write it as time samples", inQuotes(plain)),
                document.where(property->name));
  }
  const std::string_view type = opType(plain);
  std::string axes(type.size() > 6 && type.starts_with("rotate") ? type.substr(6) : "");
  std::ranges::transform(axes, axes.begin(), [](char c) { return static_cast<char>(c | 0x20); });
  std::string sorted = axes;
  std::ranges::sort(sorted);
  std::size_t width = 3;
  std::optional<char> single;  // axis of a translateX, or scaleX
  if (type == "translate" || type == "scale") {
    op.kind_ = type == "scale" ? Kind::Scale : Kind::Translate;
  } else if (type == "orient") {
    op.kind_ = Kind::Orient;
    width = 4;
  } else if (type == "transform") {
    op.kind_ = Kind::Matrix;
    width = 16;
  } else if (sorted == "xyz" || sorted == "x" || sorted == "y" || sorted == "z") {
    op.kind_ = Kind::Rotate;
    op.axes_ = axes;
    width = axes.size();
  } else if ((type.starts_with("translate") || type.starts_with("scale")) &&
             (type.ends_with('X') || type.ends_with('Y') || type.ends_with('Z'))) {
    op.kind_ = type.starts_with("scale") ? Kind::Scale : Kind::Translate;
    single = static_cast<char>(type.back() | 0x20);
    width = 1;
  } else {
    return refuse("is not an op that is known");
  }

  std::vector<UsdSample> samples = property->samples;
  if (samples.empty() && property->value) samples.push_back({0, *property->value});
  if (samples.empty()) return refuse("has no value");
  for (const UsdSample& sample : samples) {
    const auto numbers = usdNumbers(document, sample.value, width, UsdShapeOf::One, property->type);
    if (!numbers) return numbers.error();
    VectorXd value = Eigen::Map<const VectorXd>(numbers->data(), std::ssize(*numbers));
    if (single) {
      const double number = value[0];
      value = op.kind_ == Kind::Scale ? Vector3d::Ones() : Vector3d::Zero();
      value[axisOf(*single)] = number;
    }
    if (!value.allFinite()) return refuse("has a number that is not finite");
    if (op.kind_ == Kind::Orient && value.norm() == 0)
      return refuse("has a quaternion of length 0");
    if (op.kind_ == Kind::Matrix &&
        affineOf(value).matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return refuse("is a matrix that is not affine");
    }
    op.times_.push_back(sample.timeCode / timeCodesPerSecond);
    op.values_.push_back(std::move(value));
  }
  op.firstCode_ = samples.front().timeCode;
  op.lastCode_ = samples.back().timeCode;
  const bool isLinear = op.kind_ == Kind::Scale || op.kind_ == Kind::Matrix;
  if (op.inverted_ && isLinear && op.moves()) {
    return refuse("is inverted and animated, which is read of translations and rotations only");
  }
  if (op.inverted_ && isLinear && !op.at(0).matrix().allFinite()) {
    return refuse("is inverted, and has no inverse");
  }
  return op;
}

UsdXformOp UsdXformOp::scaling(double factor) {
  UsdXformOp op;
  op.kind_ = Kind::Scale;
  op.times_ = {0};
  op.values_ = {Vector3d::Constant(factor)};
  return op;
}

VectorXd UsdXformOp::valueAt(double time) const {
  const auto behind = std::ranges::upper_bound(times_, time);
  if (behind == times_.begin()) return values_.front();
  const auto before = static_cast<std::size_t>(behind - times_.begin()) - 1;
  if (behind == times_.end() || times_[before] == time) return values_[before];
  const double fraction = (time - times_[before]) / (times_[before + 1] - times_[before]);
  const VectorXd& from = values_[before];
  const VectorXd& to = values_[before + 1];
  if (kind_ != Kind::Orient) return from + fraction * (to - from);
  const Eigen::Quaterniond q = quaternionOf(from).slerp(fraction, quaternionOf(to));
  return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
}

Affine3d UsdXformOp::at(double time) const {
  const VectorXd value = valueAt(time);
  Affine3d made = Affine3d::Identity();
  switch (kind_) {
    case Kind::Translate:
      made.translation() = value;
      break;
    case Kind::Scale:
      made.linear() = Eigen::DiagonalMatrix<double, 3>(Vector3d(value));
      break;
    case Kind::Rotate:
      // Its angles are those of x, y and z, whatever the order.
      for (const char axis : axes_) {
        const double degrees = value[axes_.size() == 1 ? 0 : axisOf(axis)];
        made = Eigen::AngleAxisd(degrees * model::kRadiansPerDegree, unit(axis)) * made;
      }
      break;
    case Kind::Orient:
      made.linear() = quaternionOf(value).toRotationMatrix();
      break;
    case Kind::Matrix:
      made = affineOf(value);
      break;
  }
  return inverted_ ? made.inverse() : made;
}

/// Of the linear part: its factor of length, and how fast it changes.
CurveBound UsdXformOp::linearBound(double begin, double end) const {
  const double duration = end - begin;
  const auto perTime = [&](double change) { return duration > 0 ? change / duration : 0; };
  const VectorXd from = valueAt(begin);
  const VectorXd to = valueAt(end);
  switch (kind_) {
    case Kind::Translate:
      return {1, 0, 0};
    case Kind::Scale:
    case Kind::Matrix: {
      // Their Frobenius norms.
      const Eigen::Matrix3d a = at(begin).linear();
      const Eigen::Matrix3d b = at(end).linear();
      return {std::max(a.norm(), b.norm()), perTime((b - a).norm()), 0};
    }
    case Kind::Rotate: {
      CurveBound product{1, 0, 0};
      for (Eigen::Index i = 0; i < from.size(); ++i) {
        const double speed = perTime(std::abs(to[i] - from[i]) * model::kRadiansPerDegree);
        product = product * CurveBound{1, speed, speed * speed};
      }
      return product;
    }
    case Kind::Orient: {
      const double speed = perTime(angleBetween(quaternionOf(from), quaternionOf(to)));
      return {1, speed, speed * speed};
    }
  }
  return {};
}

CurveBound UsdXformOp::bound(const CurveBound& point, double begin, double end) const {
  const Vector3d from = at(begin).translation();
  const Vector3d to = at(end).translation();
  const double duration = end - begin;
  const CurveBound moved{std::max(from.norm(), to.norm()),
                         duration > 0 ? (to - from).norm() / duration : 0, 0};
  return linearBound(begin, end) * point + moved;
}

std::vector<model::HalfTurn> UsdXformOp::halfTurns() const {
  std::vector<model::HalfTurn> found;
  for (std::size_t i = 0; kind_ == Kind::Orient && i + 1 < times_.size(); ++i) {
    const Eigen::AngleAxisd turn(quaternionOf(values_[i + 1]) * quaternionOf(values_[i]).inverse());
    const double angle = angleBetween(quaternionOf(values_[i]), quaternionOf(values_[i + 1]));
    if (angle < model::kHalfTurnDegrees * model::kRadiansPerDegree) continue;
    found.push_back(
        {i, {times_[i], times_[i + 1]}, turn.axis(), fmt::format("samples {} and {}", i, i + 1)});
  }
  return found;
}

Result<UsdXform> UsdXform::read(const UsdDocument& document, const UsdPrim& prim,
                                double timeCodesPerSecond) {
  UsdXform xform;
  const UsdProperty* order = prim.property("xformOpOrder");
  if (order == nullptr || !order->value || *order->value == "None") return xform;
  const auto names = usdTokens(document, *order->value);
  if (!names) return names.error();
  constexpr std::size_t kMostOps = 64;
  if (names->size() > kMostOps) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("prim '{}' has {} xformOps, more than {}", prim.name, names->size(), kMostOps),
        document.where(*order->value));
  }
  for (const std::string& name : *names) {
    if (name == kReset) {
      xform.ops.clear();
      xform.resets = true;
      continue;
    }
    auto op = UsdXformOp::read(document, prim, name, timeCodesPerSecond);
    if (!op) return op.error();
    xform.ops.push_back(std::move(*op));
  }
  return xform;
}

}  // namespace t4d::formats
