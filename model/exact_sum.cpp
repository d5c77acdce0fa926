#include "model/exact_sum.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace t4d::model {
namespace {

__extension__ using UInt128 = unsigned __int128;

constexpr int kDigitBits = 32;
constexpr std::int64_t kDigitMask = (std::int64_t{1} << kDigitBits) - 1;

/// The parts of a finite double: value = mantissa * 2^exponent.
struct Parts {
  std::uint64_t mantissa;
  int exponent;
};

Parts partsOf(double value) {
  constexpr std::uint64_t kImplicit = std::uint64_t{1} << 52;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
  const std::uint64_t fraction = bits & (kImplicit - 1);
  const int biased = static_cast<int>(bits >> 52 & 0x7FF);
  if (biased == 0) return {fraction, -1074};
  return {fraction | kImplicit, biased - 1075};
}

/// Adds the product of one factor of each row, for all ways to choose other columns.
template <std::size_t N>
void addAllPermutations(ExactSum& sum, const std::array<std::array<ExactSum::Factor, N>, N>& rows,
                        std::array<const ExactSum::Factor*, N>& chosen, std::size_t row,
                        unsigned used, bool odd) {
  if (row == N) return sum.add(chosen, odd);
  bool oddHere = odd;
  for (std::size_t column = 0; column < N; ++column) {
    if ((used >> column & 1U) != 0) continue;
    chosen[row] = &rows[row][column];
    addAllPermutations(sum, rows, chosen, row + 1, used | 1U << column, oddHere);
    oddHere = !oddHere;
  }
}

template <int N>
int signOfDeterminant(const Eigen::Matrix<double, N, N>& matrix) {
  std::array<std::array<ExactSum::Factor, N>, N> rows;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) rows[i][j] = ExactSum::Factor(matrix(i, j));
  }
  ExactSum sum;
  addDeterminant(sum, rows);
  return sum.sign();
}

}  // namespace

ExactSum::Factor ExactSum::Factor::difference(double a, double b) {
  // What rounding takes from a - b is a double, too (Knuth).
  Factor factor;
  const double rounded = a - b;
  if (!std::isfinite(rounded)) {
    factor.add(a);
    factor.add(-b);
    return factor;
  }
  const double ofB = a - rounded;
  const double ofA = rounded + ofB;
  factor.add(rounded);
  factor.add((a - ofA) + (ofB - b));
  return factor;
}

void ExactSum::add(std::span<const Factor* const> factors, bool subtract) {
  assert(!factors.empty() && factors.size() <= 4);
  static const Factor one(1);
  const auto factor = [&](std::size_t i) -> const Factor& {
    return i < factors.size() ? *factors[i] : one;
  };
  for (const double a : factor(0)) {
    for (const double b : factor(1)) {
      for (const double c : factor(2)) {
        for (const double d : factor(3)) addProduct({a, b, c, d}, subtract);
      }
    }
  }
}

void ExactSum::addProduct(const std::array<double, 4>& factors, bool subtract) {
  std::array<Parts, 4> parts;
  bool negative = subtract;
  int exponent = 0;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (!std::isfinite(factors[i])) {
      finite_ = false;
      return;
    }
    parts[i] = partsOf(factors[i]);
    exponent += parts[i].exponent;
    negative = negative != std::signbit(factors[i]);
  }
  const UInt128 low = UInt128{parts[0].mantissa} * parts[1].mantissa;  // below 2^106
  const UInt128 high = UInt128{parts[2].mantissa} * parts[3].mantissa;
  // The product is that of words of 64 bits.
  const auto word = [](UInt128 value) { return static_cast<std::uint64_t>(value); };
  const UInt128 p00 = UInt128{word(low)} * word(high);
  const UInt128 p01 = UInt128{word(low)} * word(high >> 64);
  const UInt128 p10 = UInt128{word(low >> 64)} * word(high);
  const UInt128 p11 = UInt128{word(low >> 64)} * word(high >> 64);
  const UInt128 middle = (p00 >> 64) + word(p01) + word(p10);
  const UInt128 upper = (middle >> 64) + (p01 >> 64) + (p10 >> 64) + p11;
  const std::array<std::uint64_t, 4> product = {word(p00), word(middle), word(upper),
                                                word(upper >> 64)};

  const int shift = exponent - kLowestExponent;
  auto at = static_cast<std::size_t>(shift / kDigitBits);
  const int within = shift % kDigitBits;
  lowest_ = std::min(lowest_, at);
  end_ = std::max(end_, at + 2 * product.size());
  // 31 + 4 * 53 bits at most, so that nothing is left after the last word.
  UInt128 pending = 0;
  for (const std::uint64_t part : product) {
    pending += UInt128{part} << within;
    for (int half = 0; half < 2; ++half) {
      const auto digit = static_cast<std::int64_t>(word(pending) & kDigitMask);
      if (digit != 0) digits_[at] += negative ? -digit : digit;
      ++at;
      pending >>= kDigitBits;
    }
  }
  constexpr std::uint32_t kMostAdded = std::uint32_t{1} << 30;
  if (++added_ == kMostAdded) carry();
}

void ExactSum::add(const ExactSum& other) {
  ExactSum carried = other;
  carried.carry();
  carry();
  for (std::size_t i = 0; i < kDigits; ++i) digits_[i] += carried.digits_[i];
  ++added_;
  finite_ = finite_ && other.finite_;
}

/// Makes all digits but the highest, which has the sign, at least 0 and below 2^32.
void ExactSum::carry() {
  std::int64_t over = 0;
  for (std::size_t i = 0; i + 1 < kDigits; ++i) {
    digits_[i] += over;
    over = digits_[i] >> kDigitBits;
    digits_[i] &= kDigitMask;
  }
  digits_.back() += over;
  added_ = 0;
  lowest_ = 0;
  end_ = kDigits;
}

int ExactSum::sign() const {
  if (!finite_) return 0;
  std::int64_t over = 0;
  bool isZero = true;
  for (std::size_t i = lowest_; i < end_; ++i) {
    over += digits_[i];
    isZero = isZero && (over & kDigitMask) == 0;
    over >>= kDigitBits;
  }
  return over < 0 ? -1 : over > 0 || !isZero ? 1 : 0;
}

double ExactSum::dividedBy(double divisor) const {
  if (!finite_) return std::numeric_limits<double>::quiet_NaN();
  const int sign = this->sign();
  if (sign == 0) return 0;
  ExactSum size = *this;
  if (sign < 0) {
    for (std::int64_t& digit : size.digits_) digit = -digit;
  }
  size.carry();
  std::size_t top = kDigits - 1;
  while (size.digits_[top] == 0) --top;
  // The highest three digits, and whether anything follows them.
  UInt128 digits = 0;
  std::size_t lowest = top + 1;
  for (int i = 0; i < 3 && lowest > 0; ++i) {
    digits = digits << kDigitBits | static_cast<std::uint64_t>(size.digits_[--lowest]);
  }
  for (std::size_t i = 0; i < lowest; ++i) {
    if (size.digits_[i] != 0) digits |= 1;
  }
  const int exponent = static_cast<int>(lowest) * kDigitBits + kLowestExponent;
  return std::ldexp(sign * static_cast<double>(digits) / divisor, exponent);
}

void addDeterminant(ExactSum& sum, const std::array<std::array<ExactSum::Factor, 3>, 3>& rows) {
  std::array<const ExactSum::Factor*, 3> chosen{};
  addAllPermutations(sum, rows, chosen, 0, 0, false);
}

void addDeterminant(ExactSum& sum, const std::array<std::array<ExactSum::Factor, 4>, 4>& rows) {
  std::array<const ExactSum::Factor*, 4> chosen{};
  addAllPermutations(sum, rows, chosen, 0, 0, false);
}

bool isPrecise(double sum, double magnitude) {
  constexpr double kUnknown = 1e-10;
  const double unknown = std::numeric_limits<double>::epsilon() * magnitude + kVanished;
  return std::isfinite(sum) && unknown <= kUnknown * std::abs(sum);
}

int determinantSign(const Eigen::Matrix3d& matrix) { return signOfDeterminant<3>(matrix); }

int determinantSign(const Eigen::Matrix4d& matrix) { return signOfDeterminant<4>(matrix); }

int orientationSign(const std::array<Point4, 5>& points) {
  std::array<std::array<ExactSum::Factor, 4>, 4> rows;
  for (std::size_t i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 4; ++axis) {
      rows[i][static_cast<std::size_t>(axis)] =
          ExactSum::Factor::difference(points[i + 1][axis], points[0][axis]);
    }
  }
  ExactSum sum;
  addDeterminant(sum, rows);
  return sum.sign();
}

}  // namespace t4d::model
