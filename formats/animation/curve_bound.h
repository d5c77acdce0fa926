#pragma once

namespace t4d::formats {

/// Upper bounds, over an interval of time, of the norms of a function and of its first two
/// derivatives. For matrices the norm is the largest factor by which they lengthen a vector.
struct CurveBound {
  double value = 0;
  double first = 0;
  double second = 0;

  friend CurveBound operator+(const CurveBound& a, const CurveBound& b) {
    return {a.value + b.value, a.first + b.first, a.second + b.second};
  }
  /// The bound of a product, by Leibniz's rule.
  friend CurveBound operator*(const CurveBound& a, const CurveBound& b) {
    return {a.value * b.value, a.first * b.value + a.value * b.first,
            a.second * b.value + 2 * a.first * b.first + a.value * b.second};
  }
};

}  // namespace t4d::formats
