#include "t4d/measure/exact_signs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace t4d::measure {
namespace {

using model::Point3;

constexpr double kUnit = std::numeric_limits<double>::epsilon() / 2;  // of rounding
// Of the determinants computed in doubles, relative to the sum of the magnitudes of their terms.
constexpr double kBound2 = (3 + 16 * kUnit) * kUnit;
constexpr double kBound3 = (7 + 56 * kUnit) * kUnit;
// Below, products may have lost bits that are too small for a double.
constexpr double kSmall = 0x1p-800;

/// A number as a sum of doubles that do not overlap, in increasing magnitude and without zeros.
class Sum {
 public:
  Sum() = default;

  /// a - b.
  static Sum difference(double a, double b) {
    const double high = a - b;
    const double back = a - high;
    const double around = high + back;
    Sum sum;
    sum.push((a - around) + (back - b));
    sum.push(high);
    return sum;
  }

  Sum operator+(const Sum& other) const {
    // Shewchuk's FAST-EXPANSION-SUM.
    Sum sum;
    int i = 0;
    int j = 0;
    const auto next = [&] {
      const bool own =
          j == other.size_ || (i < size_ && std::abs(terms_[i]) < std::abs(other.terms_[j]));
      return own ? terms_[i++] : other.terms_[j++];
    };
    const int count = size_ + other.size_;
    if (count == 0) return sum;
    double total = next();
    for (int k = 1; k < count; ++k) {
      const auto [high, low] = added(total, next());
      sum.push(low);
      total = high;
    }
    sum.push(total);
    return sum;
  }

  Sum operator-() const {
    Sum sum = *this;
    for (int i = 0; i < size_; ++i) sum.terms_[i] = -sum.terms_[i];
    return sum;
  }
  Sum operator-(const Sum& other) const { return *this + -other; }

  Sum operator*(const Sum& other) const {
    Sum sum;
    for (int i = 0; i < other.size_; ++i) sum = sum + times(other.terms_[i]);
    return sum;
  }

  int sign() const { return size_ == 0 ? 0 : terms_[size_ - 1] > 0 ? 1 : -1; }

 private:
  struct Pair {
    double high, low;
  };

  static Pair added(double a, double b) {
    const double high = a + b;
    const double virtualB = high - a;
    const double virtualA = high - virtualB;
    return {high, (a - virtualA) + (b - virtualB)};
  }

  static Pair multiplied(double a, double b) {
    const double high = a * b;
    return {high, std::fma(a, b, -high)};
  }

  Sum times(double factor) const {
    // Shewchuk's SCALE-EXPANSION.
    Sum sum;
    if (size_ == 0) return sum;
    auto [total, low] = multiplied(terms_[0], factor);
    sum.push(low);
    for (int i = 1; i < size_; ++i) {
      const auto [high, below] = multiplied(terms_[i], factor);
      const Pair first = added(total, below);
      sum.push(first.low);
      const Pair second = added(high, first.high);
      sum.push(second.low);
      total = second.high;
    }
    sum.push(total);
    return sum;
  }

  void push(double term) {
    if (term != 0) terms_[size_++] = term;
  }

  // A determinant of three rows of differences has at most 3 * 2 * 2 * (2 * 2 * 2 * 2) of them.
  std::array<double, 192> terms_;
  int size_ = 0;
};

/// Scales numbers by a power of two so that products of three neither overflow nor underflow.
template <std::size_t N>
void scale(std::array<double, N>& numbers) {
  double largest = 0;
  for (const double number : numbers) largest = std::max(largest, std::abs(number));
  const int exponent = largest > 0 ? std::ilogb(largest) : 0;
  if (std::abs(exponent) < 100) return;
  for (double& number : numbers) number = std::ldexp(number, -exponent);
}

int exactOrientation(const Point2& a, const Point2& b, const Point2& c) {
  std::array<double, 6> n = {a.x(), a.y(), b.x(), b.y(), c.x(), c.y()};
  scale(n);
  return (Sum::difference(n[2], n[0]) * Sum::difference(n[5], n[1]) -
          Sum::difference(n[3], n[1]) * Sum::difference(n[4], n[0]))
      .sign();
}

int exactOrientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  std::array<double, 12> n = {a.x(), a.y(), a.z(), b.x(), b.y(), b.z(),
                              c.x(), c.y(), c.z(), d.x(), d.y(), d.z()};
  scale(n);
  std::array<Sum, 9> rows;  // b - a, c - a, d - a
  for (int i = 0; i < 9; ++i) rows[i] = Sum::difference(n[3 + i], n[i % 3]);
  const auto minor = [&](int i, int j) {
    return rows[3 + i] * rows[6 + j] - rows[3 + j] * rows[6 + i];
  };
  return (minor(1, 2) * rows[0] + minor(2, 0) * rows[1] + minor(0, 1) * rows[2]).sign();
}

}  // namespace

int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (b.x() - a.x()) * (c.y() - a.y());
  const double right = (b.y() - a.y()) * (c.x() - a.x());
  const double det = left - right;
  const double magnitude = std::abs(left) + std::abs(right);
  if (magnitude > kSmall && std::abs(det) > kBound2 * magnitude) return det > 0 ? 1 : -1;
  return exactOrientation(a, b, c);
}

int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Point3 u = b - a;
  const Point3 v = c - a;
  const Point3 w = d - a;
  const double yz = v.y() * w.z();
  const double zy = v.z() * w.y();
  const double zx = v.z() * w.x();
  const double xz = v.x() * w.z();
  const double xy = v.x() * w.y();
  const double yx = v.y() * w.x();
  const double det = u.x() * (yz - zy) + u.y() * (zx - xz) + u.z() * (xy - yx);
  const double magnitude = std::abs(u.x()) * (std::abs(yz) + std::abs(zy)) +
                           std::abs(u.y()) * (std::abs(zx) + std::abs(xz)) +
                           std::abs(u.z()) * (std::abs(xy) + std::abs(yx));
  if (magnitude > kSmall && std::abs(det) > kBound3 * magnitude) return det > 0 ? 1 : -1;
  return exactOrientation(a, b, c, d);
}

int movedOrientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  int sign = orientation(a, b, c, d);
  // The normal of the plane, x first.
  for (int axis = 0; axis < 3 && sign == 0; ++axis) {
    sign = orientation(acrossAxis(a, axis), acrossAxis(b, axis), acrossAxis(c, axis));
  }
  return sign;
}

}  // namespace t4d::measure
