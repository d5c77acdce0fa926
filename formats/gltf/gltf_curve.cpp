#include "formats/gltf/gltf_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "model/degrees.h"

namespace t4d::formats {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The value of a cubic Bezier curve's polar form (blossom): at (u, u, u) the curve itself.
VectorXd blossom(const MatrixXd& points, double u, double v, double w) {
  const auto between = [](const VectorXd& a, const VectorXd& b, double s) -> VectorXd {
    return (1 - s) * a + s * b;
  };
  const VectorXd a = between(points.col(0), points.col(1), u);
  const VectorXd b = between(points.col(1), points.col(2), u);
  const VectorXd c = between(points.col(2), points.col(3), u);
  return between(between(a, b, v), between(b, c, v), w);
}

/// Twice the angle between two quaternions of length 1, as seen on the shorter way.
double turnBetween(const VectorXd& a, const VectorXd& b) {
  const VectorXd nearer = a.dot(b) < 0 ? VectorXd(-b) : b;
  return 4 * std::atan2((a - nearer).norm(), (a + nearer).norm());
}

}  // namespace

Result<GltfCurve> GltfCurve::read(const InputFile& file, const tinygltf::Model& model,
                                  int animation, int sampler, Kind kind, int width) {
  const Place where =
      gltfElement(file, "animations", animation, fmt::format(".samplers[{}]", sampler));
  const auto* from =
      elementAt(model.animations[static_cast<std::size_t>(animation)].samplers, sampler);
  if (from == nullptr) return invalid("does not exist", where);
  GltfCurve curve;
  curve.width_ = width;
  const bool rotation = kind == Kind::Rotation;
  curve.rotation_ = rotation;
  if (from->interpolation == "STEP") {
    curve.interpolation_ = Interpolation::Step;
  } else if (from->interpolation == "CUBICSPLINE") {
    curve.interpolation_ = Interpolation::CubicSpline;
  } else if (from->interpolation != "LINEAR" && !from->interpolation.empty()) {
    return invalid(fmt::format("interpolation '{}', expected LINEAR, STEP or CUBICSPLINE",
                               from->interpolation),
                   where);
  }
  auto times = readGltfAccessor(file, model, from->input, 1);
  if (!times) return times.error();
  if (kind == Kind::Truth && curve.interpolation_ != Interpolation::Step) {
    return invalid("interpolates truth values, expected STEP", where);
  }
  // Weights are scalars, one after the other.
  auto numbers = readGltfAccessor(file, model, from->output, kind == Kind::Weights ? 1 : width);
  if (!numbers) return numbers.error();
  curve.times_ = std::move(*times);
  curve.numbers_ = std::move(*numbers);

  if (curve.times_.empty()) return invalid("has no keys", where);
  for (std::size_t i = 0; i < curve.times_.size(); ++i) {
    const double time = curve.times_[i];
    if (!std::isfinite(time)) {
      return invalid(fmt::format("key {} is at time {}", i, time), where);
    }
    if (i > 0 && !(time > curve.times_[i - 1])) {
      return invalid(fmt::format("key {} is at time {}, not after the key before it, at {}", i,
                                 time, curve.times_[i - 1]),
                     where);
    }
  }
  const std::size_t perKey = curve.interpolation_ == Interpolation::CubicSpline ? 3 : 1;
  const std::size_t expected = curve.times_.size() * perKey * static_cast<std::size_t>(width);
  if (curve.numbers_.size() != expected) {
    return invalid(fmt::format("{} keys with {} numbers in all, expected {}", curve.times_.size(),
                               curve.numbers_.size(), expected),
                   where);
  }
  for (double& number : curve.numbers_) {
    if (!std::isfinite(number)) return invalid("a number that is not finite", where);
    if (kind == Kind::Truth) number = number != 0 ? 1 : 0;
  }
  for (std::size_t i = 0; rotation && i < curve.times_.size(); ++i) {
    const std::size_t at = (i * perKey + perKey / 2) * 4;
    const double norm = Eigen::Map<const Eigen::Vector4d>(&curve.numbers_[at]).norm();
    if (!(norm > 0)) {
      return invalid(fmt::format("key {} is a quaternion of length {}, expected 1", i, norm),
                     where);
    }
    if (perKey == 1) Eigen::Map<Eigen::Vector4d>(&curve.numbers_[at]) /= norm;
  }
  return curve;
}

VectorXd GltfCurve::value(std::size_t key) const {
  const auto width = static_cast<std::size_t>(width_);
  const bool cubic = interpolation_ == Interpolation::CubicSpline;
  return Eigen::Map<const VectorXd>(&numbers_[cubic ? (3 * key + 1) * width : key * width], width_);
}

std::span<const double> GltfCurve::timesFromZero() const {
  return {std::ranges::lower_bound(times_, 0.0), times_.end()};
}

std::vector<double> GltfCurve::jumps() const {
  std::vector<double> found;
  if (interpolation_ != Interpolation::Step) return found;
  for (std::size_t key = 1; key < times_.size(); ++key) {
    if (times_[key] > 0 && value(key) != value(key - 1)) found.push_back(times_[key]);
  }
  return found;
}

std::vector<model::HalfTurn> GltfCurve::halfTurns() const {
  std::vector<model::HalfTurn> found;
  if (!rotation_ || interpolation_ != Interpolation::Linear) return found;
  for (std::size_t key = 0; key + 1 < times_.size(); ++key) {
    if (times_[key + 1] <= 0) continue;
    const Eigen::Quaterniond from(Eigen::Vector4d(value(key)));
    Eigen::Quaterniond turn = Eigen::Quaterniond(Eigen::Vector4d(value(key + 1))) * from.inverse();
    // slerp takes the shorter way.
    if (turn.w() < 0) turn.coeffs() *= -1;
    if (turn.w() > std::cos(model::kHalfTurnDegrees * model::kRadiansPerDegree / 2)) continue;
    found.push_back({key,
                     {times_[key], times_[key + 1]},
                     turn.vec().normalized(),
                     fmt::format("keys {} and {}", key, key + 1)});
  }
  return found;
}

std::size_t GltfCurve::keyAt(double time, Side side) const {
  const auto behind = side == Side::Before ? std::lower_bound(times_.begin(), times_.end(), time)
                                           : std::upper_bound(times_.begin(), times_.end(), time);
  return behind == times_.begin() ? 0 : static_cast<std::size_t>(behind - times_.begin() - 1);
}

MatrixXd GltfCurve::segment(std::size_t key) const {
  const double duration = times_[key + 1] - times_[key];
  const VectorXd from = value(key);
  const VectorXd to = value(key + 1);
  VectorXd out = (to - from) / duration;
  VectorXd in = out;
  if (interpolation_ == Interpolation::CubicSpline) {
    const auto width = static_cast<std::size_t>(width_);
    out = Eigen::Map<const VectorXd>(&numbers_[(3 * key + 2) * width], width_);
    in = Eigen::Map<const VectorXd>(&numbers_[3 * (key + 1) * width], width_);
  }
  // Converts Hermite to Bezier.
  MatrixXd points(width_, 4);
  points << from, from + duration / 3 * out, to - duration / 3 * in, to;
  return points;
}

VectorXd GltfCurve::at(double time, Side side) const {
  const std::size_t key = keyAt(time, side);
  const bool constant =
      interpolation_ == Interpolation::Step || key + 1 == times_.size() || time <= times_[key];
  VectorXd result;
  if (constant) {
    result = value(key);
  } else if (rotation_ && interpolation_ == Interpolation::Linear) {
    const Eigen::Quaterniond from(Eigen::Vector4d(value(key)));
    const Eigen::Quaterniond to(Eigen::Vector4d(value(key + 1)));
    const double u = (time - times_[key]) / (times_[key + 1] - times_[key]);
    result = from.slerp(u, to).coeffs();
  } else {
    const double u = (time - times_[key]) / (times_[key + 1] - times_[key]);
    result = blossom(segment(key), u, u, u);
  }
  return rotation_ ? VectorXd(result.normalized()) : result;
}

GltfCurve::Hull GltfCurve::hull(double begin, double end) const {
  const std::size_t key = keyAt(begin, Side::Behind);
  Hull hull;
  if (interpolation_ == Interpolation::Step || key + 1 == times_.size() || end <= times_[key]) {
    hull.value = value(key);
    hull.first = hull.second = VectorXd::Zero(width_);
    return hull;
  }
  const double duration = times_[key + 1] - times_[key];
  const double u = std::clamp((begin - times_[key]) / duration, 0.0, 1.0);
  const double v = std::clamp((end - times_[key]) / duration, 0.0, 1.0);
  const MatrixXd whole = segment(key);
  hull.value.resize(width_, 4);
  hull.value << blossom(whole, u, u, u), blossom(whole, u, u, v), blossom(whole, u, v, v),
      blossom(whole, v, v, v);
  const auto differences = [&](const MatrixXd& points) -> MatrixXd {
    const Eigen::Index n = points.cols() - 1;
    return static_cast<double>(n) / (end - begin) * (points.rightCols(n) - points.leftCols(n));
  };
  if (interpolation_ == Interpolation::Linear) {
    // Differences of rounded points would pretend a second derivative.
    hull.first = (value(key + 1) - value(key)) / duration;
    hull.second = VectorXd::Zero(width_);
  } else {
    hull.first = differences(hull.value);
    hull.second = differences(hull.first);
  }
  return hull;
}

CurveBound GltfCurve::rotationBound(double begin, double end) const {
  const std::size_t key = keyAt(begin, Side::Behind);
  const bool constant =
      interpolation_ == Interpolation::Step || key + 1 == times_.size() || end <= times_[key];
  if (constant) return {1, 0, 0};
  if (interpolation_ == Interpolation::Linear) {
    // A rotation about a fixed axis at a constant speed w has derivatives of norms w and w^2.
    const double speed = turnBetween(value(key), value(key + 1)) / (times_[key + 1] - times_[key]);
    return {1, speed, speed * speed};
  }
  // With q = r n, |n| = 1: n' is the part of q' across n divided by r, so |n'| <= |q'| / r; once
  // more, |n''| <= |q''| / r + 3 |q'|^2 / r^2. The matrix is a product of n with itself, of norm 1,
  // so that its derivatives are at most 2 |n'| and 2 |n''| + 2 |n'|^2.
  const Hull q = hull(begin, end);
  const VectorXd middle = at(begin / 2 + end / 2, Side::Behind);
  const double r = (middle.transpose() * q.value).minCoeff();
  if (!(r > 0)) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    return {1, kInfinite, kInfinite};
  }
  const double first = q.first.colwise().norm().maxCoeff() / r;
  const double second = q.second.colwise().norm().maxCoeff() / r + 3 * first * first;
  return {1, 2 * first, 2 * second + 2 * first * first};
}

}  // namespace t4d::formats
