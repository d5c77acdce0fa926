#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

#include "model/number.h"
#include "model/slab_groups.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

__extension__ typedef __int128 Int128;            // NOLINT(modernize-use-using)
__extension__ typedef unsigned __int128 Uint128;  // NOLINT(modernize-use-using)

/// mantissa * 10^exponent.
struct Decimal {
  Int128 mantissa = 0;
  int exponent = 0;
};

/// The shortest decimal number that reads back as `value`, which must be finite.
Decimal decimalOf(double value) {
  std::string text;
  appendNumber(text, std::abs(value), std::chars_format::scientific);
  // d.ddde+dd, possibly without the point.
  Decimal decimal;
  const char* at = text.c_str();
  bool fraction = false;
  for (; *at != 'e'; ++at) {
    if (*at == '.') {
      fraction = true;
      continue;
    }
    decimal.mantissa = 10 * decimal.mantissa + (*at - '0');
    if (fraction) --decimal.exponent;
  }
  decimal.exponent += numberIn<int>(withoutPlus(at + 1)).value();
  if (value < 0) decimal.mantissa = -decimal.mantissa;
  return decimal;
}

/// a * x + b * y with a common exponent; nothing if that takes more than 128 bits.
std::optional<Decimal> combined(Decimal a, Int128 x, Decimal b, Int128 y) {
  if (a.mantissa == 0) a.exponent = b.exponent;
  if (b.mantissa == 0) b.exponent = a.exponent;
  const int exponent = std::min(a.exponent, b.exponent);
  for (Decimal* decimal : {&a, &b}) {
    for (; decimal->exponent > exponent; --decimal->exponent) {
      if (__builtin_mul_overflow(decimal->mantissa, Int128{10}, &decimal->mantissa)) return {};
    }
  }
  Decimal sum{0, exponent};
  if (__builtin_mul_overflow(a.mantissa, x, &a.mantissa) ||
      __builtin_mul_overflow(b.mantissa, y, &b.mantissa) ||
      __builtin_add_overflow(a.mantissa, b.mantissa, &sum.mantissa)) {
    return {};
  }
  return sum;
}

/// The double nearest to decimal / n; nothing if it is out of range.
std::optional<double> quotient(const Decimal& decimal, std::uint64_t n) {
  // 128 bits have 39 digits; 20 zeros may follow the point, and a double has 17 digits. Further
  // digits only decide on which side of a tie the number lies.
  constexpr int kFractionDigits = 60;
  const bool negative = decimal.mantissa < 0;
  const Uint128 magnitude =
      negative ? -static_cast<Uint128>(decimal.mantissa) : static_cast<Uint128>(decimal.mantissa);
  std::string text;
  for (Uint128 whole = magnitude / n; whole != 0; whole /= 10) {
    text.push_back(static_cast<char>('0' + static_cast<int>(whole % 10)));
  }
  text.push_back(negative ? '-' : '0');
  std::reverse(text.begin(), text.end());
  Uint128 rest = magnitude % n;
  int exponent = decimal.exponent;
  for (int i = 0; i < kFractionDigits && rest != 0; ++i, --exponent) {
    text.push_back(static_cast<char>('0' + static_cast<int>(10 * rest / n)));
    rest = 10 * rest % n;
  }
  if (rest != 0) {
    text.push_back('1');
    --exponent;
  }
  text += 'e' + std::to_string(exponent);
  return numberIn<double>(text);
}

/// The mark nearest to `time` if it is within kSameTimeUlps, otherwise `time`.
double nearestMark(const TimeSpan& span, double time, std::initializer_list<double> marks) {
  const double nearest = *std::min_element(marks.begin(), marks.end(), [&](double a, double b) {
    return std::abs(time - a) < std::abs(time - b);
  });
  const double largest = std::max({std::abs(time), std::abs(span.begin), std::abs(span.end)});
  const double ulp = largest - std::nextafter(largest, 0);
  return std::abs(time - nearest) <= kSameTimeUlps * ulp ? nearest : time;
}

}  // namespace

double steppedTime(double begin, double step, std::uint64_t k) {
  if (std::isfinite(begin) && std::isfinite(step)) {
    if (const auto sum = combined(decimalOf(begin), 1, decimalOf(step), k)) {
      if (const auto time = quotient(*sum, 1)) return *time;
    }
  }
  return std::fma(static_cast<double>(k), step, begin);
}

double dividedTime(const TimeSpan& span, std::uint64_t k, std::uint64_t n) {
  const auto [begin, end] = span;
  if (k == 0) return begin;
  if (k == n) return end;
  if (std::isfinite(begin) && std::isfinite(end)) {
    const auto sum = combined(decimalOf(begin), Int128{n} - k, decimalOf(end), k);
    if (sum) {
      if (const auto time = quotient(*sum, n)) return *time;
    }
  }
  return std::lerp(begin, end, static_cast<double>(k) / static_cast<double>(n));
}

std::vector<double> steppedTimes(double begin, double step, std::uint64_t count) {
  std::vector<double> times;
  times.reserve(count);
  for (std::uint64_t k = 0; k < count; ++k) times.push_back(steppedTime(begin, step, k));
  return times;
}

std::vector<double> evenTimes(const TimeSpan& span, std::uint64_t count) {
  std::vector<double> times;
  times.reserve(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    times.push_back(count == 1 ? span.begin : dividedTime(span, k, count - 1));
  }
  return times;
}

std::optional<double> timeWithin(const TimeSpan& span, double time) {
  if (!std::isfinite(time)) return std::nullopt;
  const double meant = nearestMark(span, time, {span.begin, span.end});
  if (!(meant >= span.begin && meant <= span.end)) return std::nullopt;
  return meant;
}

std::optional<double> timeWithin(const Source& source, double time) {
  if (source.slabCount() == 0) return std::nullopt;
  const TimeSpan span = timeSpanOf(source);
  if (!timeWithin(span, time)) return std::nullopt;
  // The layers nearest to the time are those of the first slab that ends later and the one before.
  const std::size_t later = std::min(firstSlabEndingAfter(source, time), source.slabCount() - 1);
  const TimeSpan after = source.timeSpan(later);
  const double before = later == 0 ? after.end : endOfSlab(source, later - 1);
  return nearestMark(span, time, {before, after.begin, after.end});
}

}  // namespace t4d::model
