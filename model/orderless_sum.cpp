#include "model/orderless_sum.h"

#include <array>
#include <cmath>

#include "model/exact_sum.h"

namespace t4d::model {
namespace {

void addTo(ExactSum& sum, double value) {
  const ExactSum::Factor factor(value);
  const std::array<const ExactSum::Factor*, 1> factors = {&factor};
  sum.add(factors, false);
}

}  // namespace

void OrderlessSum::add(double value) {
  if (std::isfinite(value)) {
    addTo(finite_, value);
  } else {
    isFinite_ = false;
    other_ += value;
  }
}

void OrderlessSum::add(const OrderlessSum& other) {
  finite_.add(other.finite_);
  isFinite_ = isFinite_ && other.isFinite_;
  other_ += other.other_;
}

double OrderlessSum::value() const { return isFinite_ ? finite_.dividedBy(1) : other_; }

std::vector<double> OrderlessSum::terms() const {
  if (!isFinite_) return {other_};
  std::vector<double> terms;
  ExactSum rest = finite_;
  while (rest.sign() != 0) {
    terms.push_back(rest.dividedBy(1));
    // A sum beyond the range of doubles has no terms that are finite.
    if (!std::isfinite(terms.back())) return {terms.back()};
    addTo(rest, -terms.back());
  }
  return terms;
}

}  // namespace t4d::model
