#pragma once

#include <cstddef>
#include <vector>

#include "model/exact_sum.h"

namespace t4d::model {

/// A sum of doubles that does not depend on their order, nor on how they are grouped: it is exact,
/// and rounded once, where `value` is asked for.
class OrderlessSum {
 public:
  void add(double value);
  void add(const OrderlessSum& other);

  /// The sum, rounded to the nearest double. Infinite or NaN if one of the values was.
  double value() const;
  /// A few doubles with exactly this sum, the largest first; to be added to another one.
  std::vector<double> terms() const;

 private:
  ExactSum finite_;
  double other_ = 0;  // sum of those that are not finite
  bool isFinite_ = true;
};

}  // namespace t4d::model
