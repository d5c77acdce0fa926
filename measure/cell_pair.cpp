#include "measure/cell_pair.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

namespace t4d::measure {
namespace {

using model::Point3;
using model::Point4;

__extension__ using Int128 = __int128;
/// An integer of any size; up to 512 bits without an allocation, enough for most coordinates.
using BigInt = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<512, 0, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked,
                                           std::allocator<boost::multiprecision::limb_type>>,
    boost::multiprecision::et_off>;

/// Corners 0 to 3 are those of a, 4 to 7 those of b. A set of corners is a mask of bits.
using Corners8 = std::array<Point4, 8>;
using Mask = std::uint8_t;
constexpr Mask kMaskA = 0x0F;
constexpr Mask kMaskB = 0xF0;
constexpr Mask kAll = 0xFF;

int signOf(double value) { return (value > 0) - (value < 0); }
int signOf(Int128 value) { return (value > 0) - (value < 0); }
int signOf(const BigInt& value) { return value.sign(); }

/// The masks of the 28 sets of six corners with at least two of each cell (an edge and a cell, or
/// two triangles).
constexpr std::array<Mask, 28> kSixes = [] {
  std::array<Mask, 28> sixes{};
  std::size_t count = 0;
  for (unsigned mask = 0; mask < 256; ++mask) {
    if (std::popcount(mask) == 6) sixes[count++] = static_cast<Mask>(mask);
  }
  return sixes;
}();

/// The 5-point determinants of eight points in R^4: det [p; 1] over the points of a mask, in order.
/// Number is double, or an integer type, which makes them exact.
template <class Number>
class Determinants {
 public:
  /// `u[i]` is corner i less corner 7.
  explicit Determinants(const std::array<std::array<Number, 4>, 7>& u) {
    std::array<std::array<Number, 7>, 7> low;   // minors of x and y
    std::array<std::array<Number, 7>, 7> high;  // minors of z and t
    for (std::size_t i = 0; i < 7; ++i) {
      for (std::size_t j = i + 1; j < 7; ++j) {
        low[i][j] = u[i][0] * u[j][1] - u[j][0] * u[i][1];
        high[i][j] = u[i][2] * u[j][3] - u[j][2] * u[i][3];
      }
    }
    // Minors with corner 7 have four vectors: expanded by minors of the first two rows (Laplace).
    for (std::size_t i = 0; i < 7; ++i) {
      for (std::size_t j = i + 1; j < 7; ++j) {
        for (std::size_t k = j + 1; k < 7; ++k) {
          for (std::size_t l = k + 1; l < 7; ++l) {
            of_[0x80U | 1U << i | 1U << j | 1U << k | 1U << l] =
                ((low[i][j] * high[k][l] + low[k][l] * high[i][j]) -
                 (low[i][k] * high[j][l] + low[j][l] * high[i][k])) +
                (low[i][l] * high[j][k] + low[j][k] * high[i][l]);
          }
        }
      }
    }
    // Those without it are expanded by the row of ones.
    for (unsigned mask = 0; mask < 0x80; ++mask) {
      if (std::popcount(mask) != 5) continue;
      Number sum = 0;
      bool plus = true;
      for (unsigned left = mask; left != 0; left &= left - 1) {
        const Number& part = of_[0x80U | (mask & ~(left & -left))];
        if (plus) {
          sum += part;
        } else {
          sum -= part;
        }
        plus = !plus;
      }
      of_[mask] = sum;
    }
  }

  const Number& of(Mask mask) const { return of_[mask]; }

 private:
  std::array<Number, 256> of_;
};

/// Each coordinate times a power of two of its own, so that all are integers. That changes no sign.
struct Integers {
  std::array<std::array<double, 8>, 4> values{};  ///< by axis, then by corner; whole numbers
  std::array<int, 4> exponents{};                 ///< values * 2^exponent are the coordinates
  /// A bound of all numbers on the way to a determinant; infinity for a very large one.
  double bound = 0;
};

Integers integersOf(const Corners8& corners) {
  Integers integers;
  integers.bound = 128;  // 24 products in each of 5 determinants
  for (std::size_t axis = 0; axis < 4; ++axis) {
    int lowest = std::numeric_limits<int>::max();
    for (const Point4& corner : corners) {
      const double value = corner[static_cast<Eigen::Index>(axis)];
      if (value == 0) continue;
      int exponent = 0;
      const auto mantissa =
          static_cast<std::int64_t>(std::ldexp(std::frexp(std::abs(value), &exponent), 53));
      lowest =
          std::min(lowest, exponent - 53 + std::countr_zero(static_cast<std::uint64_t>(mantissa)));
    }
    if (lowest == std::numeric_limits<int>::max()) lowest = 0;
    integers.exponents[axis] = lowest;
    double most = 0;
    double least = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      // Infinite if the exponents are too far apart; then the bound is, too, and this is not used.
      const double value = std::ldexp(corners[i][static_cast<Eigen::Index>(axis)], -lowest);
      integers.values[axis][i] = value;
      most = i == 0 ? value : std::max(most, value);
      least = i == 0 ? value : std::min(least, value);
    }
    integers.bound *= std::max(1.0, most - least);
    // Differences must be exact in double precision, too.
    if (!(std::max(std::abs(most), std::abs(least)) <= 0x1p52)) {
      integers.bound = std::numeric_limits<double>::infinity();
    }
  }
  return integers;
}

BigInt bigIntOf(double value, int exponent) {
  // value / 2^exponent, which is a whole number.
  int own = 0;
  const double fraction = std::frexp(value, &own);
  BigInt whole = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int shift = own - 53 - exponent;
  if (shift >= 0) return whole << shift;
  return whole >> -shift;  // only zeros are shifted out
}

/// numerator / denominator * 2^exponent, rounded once (to nearest, unless it is subnormal).
double quotient(BigInt numerator, BigInt denominator, int exponent) {
  if (numerator == 0) return 0;
  const bool negative = (numerator < 0) != (denominator < 0);
  numerator = abs(numerator);
  denominator = abs(denominator);
  const int shift = 65 - static_cast<int>(msb(numerator)) + static_cast<int>(msb(denominator));
  if (shift > 0) numerator <<= shift;
  if (shift < 0) denominator <<= -shift;
  BigInt rest;
  BigInt whole;
  divide_qr(numerator, denominator, whole, rest);
  // 65 or 66 bits: the lowest of 64 says whether anything is left.
  const unsigned extra = static_cast<unsigned>(msb(whole)) - 63;
  const BigInt top = whole >> extra;
  auto bits = static_cast<std::uint64_t>(top);
  if (rest != 0 || (top << extra) != whole) bits |= 1;
  const double value =
      std::ldexp(static_cast<double>(bits), static_cast<int>(extra) - shift + exponent);
  return negative ? -value : value;
}

/// A corner of what the cells have in common: coefficients of the corners of the cells, of equal
/// sign for those of a, and their sum.
template <class Number>
struct Combination {
  std::array<Number, 8> weights{};  // not negative; those of b not used
  Number sum = 0;
};

template <class Number>
double asDouble(const Number& value) {
  return static_cast<double>(value);
}

/// The point of a combination, in double precision.
template <class Number>
Point4 pointOf(const Combination<Number>& combination, const Corners8& corners) {
  // Relative to a corner with a weight, so that a common point that is a corner comes out as it.
  std::size_t base = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (combination.weights[i] > combination.weights[base]) base = i;
  }
  Point4 offset = Point4::Zero();
  const double sum = asDouble(combination.sum);
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == base || combination.weights[i] == 0) continue;
    offset += asDouble(combination.weights[i]) / sum * (corners[i] - corners[base]);
  }
  return corners[base] + offset;
}

/// The point of a combination whose weights may exceed the range of doubles. Each coordinate is
/// computed exactly and rounded once.
Point4 roundedPointOf(const Combination<BigInt>& combination, const Corners8& corners) {
  Point4 point;
  for (int axis = 0; axis < 4; ++axis) {
    int lowest = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < 4; ++i) {
      if (corners[i][axis] == 0) continue;
      int exponent = 0;
      std::frexp(corners[i][axis], &exponent);
      lowest = std::min(lowest, exponent - 53);
    }
    if (lowest == std::numeric_limits<int>::max()) lowest = 0;
    BigInt sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += combination.weights[i] * bigIntOf(corners[i][axis], lowest);
    }
    point[axis] = quotient(sum, combination.sum, lowest);
  }
  return point;
}

template <class Number>
Point4 pointFor(const Combination<Number>& combination, const Corners8& corners) {
  if constexpr (std::is_same_v<Number, BigInt>) {
    return roundedPointOf(combination, corners);
  } else {
    return pointOf(combination, corners);
  }
}

/// Collects corners of what two cells have in common.
class Collected {
 public:
  void add(const Point4& point, Mask support) {
    if (supports_ == 0 || point[3] < meeting_.timeBegin) {
      meeting_.timeBegin = point[3];
      meeting_.point = point.head<3>();
    }
    if (supports_ == 0 || point[3] > meeting_.timeEnd) meeting_.timeEnd = point[3];
    supports_ |= support;
  }
  bool any() const { return supports_ != 0; }
  /// The mean of all corners is an interior point of the common polytope; it is one of both cells
  /// if each corner of these has a weight in one of them.
  bool inside() const { return supports_ == kAll; }
  CellMeeting& meeting() { return meeting_; }

 private:
  CellMeeting meeting_;
  Mask supports_ = 0;
};

/// Signs of the coefficients of a dependency, those of b reversed: equal for a common point.
enum class Answer : std::uint8_t { No, Yes, Unknown };

/// The answer for one set of six corners; `sign` gives those of its determinants, 2 if not known.
template <class SignOf>
Answer answerOf(Mask six, SignOf sign) {
  bool plus = false;
  bool minus = false;
  bool unknown = false;
  bool even = true;
  for (unsigned left = six; left != 0; left &= left - 1) {
    const unsigned bit = left & -left;
    const int found = sign(static_cast<Mask>(six & ~bit));
    if (found == 2) {
      unknown = true;
    } else {
      const bool isPlus = (found > 0) == (even == ((bit & kMaskA) != 0));
      if (found != 0) (isPlus ? plus : minus) = true;
      if (plus && minus) return Answer::No;
    }
    even = !even;
  }
  if (unknown) return Answer::Unknown;
  return plus || minus ? Answer::Yes : Answer::No;
}

template <class Number>
Combination<Number> combinationOf(Mask six, const Determinants<Number>& determinants,
                                  Mask& support) {
  Combination<Number> combination;
  support = 0;
  for (unsigned left = six; left != 0; left &= left - 1) {
    const unsigned bit = left & -left;
    const Number& value = determinants.of(static_cast<Mask>(six & ~bit));
    const int sign = signOf(value);
    if (sign == 0) continue;
    support |= static_cast<Mask>(bit);
    if ((bit & kMaskA) == 0) continue;
    // All of a have the same sign, alternating with the order in the set.
    const Number weight = sign < 0 ? Number(-value) : value;
    combination.weights[static_cast<std::size_t>(std::countr_zero(bit))] = weight;
    combination.sum += weight;
  }
  return combination;
}

/// Whether any determinant of all corners of `cell` and one more is other than 0, so that the cell
/// is not flat.
template <class Number>
bool isSolid(const Determinants<Number>& determinants, Mask cell) {
  for (unsigned bit = 1; bit <= 0x80; bit <<= 1) {
    if ((cell & bit) != 0) continue;
    if (signOf(determinants.of(static_cast<Mask>(cell | bit))) != 0) return true;
  }
  return false;
}

/// Three answers: nothing (the points do not span R^4), or whether they meet.
struct Decision {
  bool spans = true;
  std::optional<CellMeeting> meeting;
};

/// Decides with exact determinants.
template <class Number>
Decision decideExactly(const Determinants<Number>& determinants, const Corners8& corners) {
  Collected collected;
  bool spans = false;
  for (unsigned mask = 0; mask < 256 && !spans; ++mask) {
    if (std::popcount(mask) == 5) spans = signOf(determinants.of(static_cast<Mask>(mask))) != 0;
  }
  if (!spans) return {false, {}};
  for (const Mask six : kSixes) {
    const auto sign = [&](Mask five) { return signOf(determinants.of(five)); };
    if (answerOf(six, sign) != Answer::Yes) continue;
    Mask support = 0;
    const Combination<Number> combination = combinationOf(six, determinants, support);
    collected.add(pointFor(combination, corners), support);
  }
  if (!collected.any()) return {true, {}};
  collected.meeting().crosses =
      collected.inside() && isSolid(determinants, kMaskA) && isSolid(determinants, kMaskB);
  return {true, collected.meeting()};
}

// ---- points that lie in one hyperplane ----

/// The determinant of a square matrix, by its first row.
BigInt determinant(const std::vector<std::vector<BigInt>>& rows) {
  const std::size_t size = rows.size();
  if (size == 0) return 1;
  BigInt sum = 0;
  for (std::size_t column = 0; column < size; ++column) {
    if (rows[0][column] == 0) continue;
    std::vector<std::vector<BigInt>> rest;
    for (std::size_t row = 1; row < size; ++row) {
      rest.emplace_back();
      for (std::size_t k = 0; k < size; ++k) {
        if (k != column) rest.back().push_back(rows[row][k]);
      }
    }
    const BigInt part = rows[0][column] * determinant(rest);
    sum += column % 2 == 0 ? part : BigInt(-part);
  }
  return sum;
}

using Whole8 = std::array<std::array<BigInt, 4>, 8>;  // corners as integers, less corner 7

/// Axes, as many as the points span dimensions, onto which these can be projected one to one.
std::vector<std::size_t> spannedAxes(const Whole8& points) {
  std::vector<std::size_t> axes;
  std::vector<std::array<BigInt, 4>> rows(points.begin(), points.end());
  std::size_t rank = 0;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    std::size_t pivot = rank;
    while (pivot < rows.size() && rows[pivot][axis] == 0) ++pivot;
    if (pivot == rows.size()) continue;
    std::swap(rows[rank], rows[pivot]);
    for (std::size_t row = rank + 1; row < rows.size(); ++row) {
      const BigInt factor = rows[row][axis];
      if (factor == 0) continue;
      for (std::size_t k = axis; k < 4; ++k) {
        rows[row][k] = rows[row][k] * rows[rank][axis] - factor * rows[rank][k];
      }
    }
    axes.push_back(axis);
    ++rank;
  }
  return axes;
}

/// Six times the oriented volume of a cell of a hyperplane, projected onto `axes`.
BigInt volumeOf(const Whole8& points, std::size_t first, const std::vector<std::size_t>& axes) {
  std::vector<std::vector<BigInt>> rows;
  for (std::size_t i = first + 1; i < first + 4; ++i) {
    rows.emplace_back();
    for (const std::size_t axis : axes)
      rows.back().push_back(points[i][axis] - points[first][axis]);
  }
  return determinant(rows);
}

/// The meeting of two cells whose corners span only d < 4 dimensions, as two cells of a common
/// hyperplane or two flat ones: there, the smallest common faces have d + 2 corners.
std::optional<CellMeeting> meetingInHyperplane(const Whole8& points, const Corners8& corners) {
  const std::vector<std::size_t> axes = spannedAxes(points);
  const int size = static_cast<int>(axes.size()) + 2;
  Collected collected;
  for (unsigned mask = 0; mask < 256; ++mask) {
    if (std::popcount(mask) != size || (mask & kMaskA) == 0 || (mask & kMaskB) == 0) continue;
    Combination<BigInt> combination;
    Mask support = 0;
    bool plus = false;
    bool minus = false;
    bool even = true;
    for (unsigned left = mask; left != 0 && !(plus && minus); left &= left - 1, even = !even) {
      const unsigned bit = left & -left;
      std::vector<std::size_t> others;
      for (unsigned rest = mask & ~bit; rest != 0; rest &= rest - 1) {
        others.push_back(static_cast<std::size_t>(std::countr_zero(rest)));
      }
      std::vector<std::vector<BigInt>> rows;
      for (std::size_t i = 1; i < others.size(); ++i) {
        rows.emplace_back();
        for (const std::size_t axis : axes) {
          rows.back().push_back(points[others[i]][axis] - points[others[0]][axis]);
        }
      }
      BigInt value = determinant(rows);
      if (value == 0) continue;
      const bool isPlus = (value > 0) == (even == ((bit & kMaskA) != 0));
      (isPlus ? plus : minus) = true;
      support |= static_cast<Mask>(bit);
      if ((bit & kMaskA) == 0) continue;
      if (value < 0) value = -value;
      combination.weights[static_cast<std::size_t>(std::countr_zero(bit))] = value;
      combination.sum += value;
    }
    if (plus == minus) continue;  // contradictory, or all of them 0
    collected.add(roundedPointOf(combination, corners), support);
  }
  if (!collected.any()) return std::nullopt;
  if (axes.size() == 3 && collected.inside()) {
    collected.meeting().coincides = volumeOf(points, 0, axes) * volumeOf(points, 4, axes) > 0;
  }
  return collected.meeting();
}

Whole8 wholeOf(const Corners8& corners, const Integers& integers) {
  Whole8 points;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    const auto index = static_cast<Eigen::Index>(axis);
    const BigInt base = bigIntOf(corners[7][index], integers.exponents[axis]);
    for (std::size_t i = 0; i < 8; ++i) {
      points[i][axis] = bigIntOf(corners[i][index], integers.exponents[axis]) - base;
    }
  }
  return points;
}

template <class Number>
Determinants<Number> smallDeterminants(const Integers& integers) {
  std::array<std::array<Number, 4>, 7> u;
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t axis = 0; axis < 4; ++axis) {
      u[i][axis] = static_cast<Number>(integers.values[axis][i] - integers.values[axis][7]);
    }
  }
  return Determinants<Number>(u);
}

std::optional<CellMeeting> meetingByBigIntegers(const Corners8& corners, const Integers& integers,
                                                bool crossingsOnly) {
  const Whole8 points = wholeOf(corners, integers);
  std::array<std::array<BigInt, 4>, 7> u;
  std::copy_n(points.begin(), 7, u.begin());
  const Decision decision = decideExactly(Determinants<BigInt>(u), corners);
  if (decision.spans || crossingsOnly) return decision.meeting;
  return meetingInHyperplane(points, corners);
}

/// For cells that the filter does not decide: with the smallest integers that suffice.
std::optional<CellMeeting> meetingByIntegers(const Corners8& corners, bool crossingsOnly) {
  constexpr double kMostInDouble = 0x1p53;
  constexpr double kMostInInt128 = 0x1p126;
  const Integers integers = integersOf(corners);
  Decision decision{false, {}};
  if (integers.bound <= kMostInDouble) {
    decision = decideExactly(smallDeterminants<double>(integers), corners);
  } else if (integers.bound <= kMostInInt128) {
    decision = decideExactly(smallDeterminants<Int128>(integers), corners);
  } else {
    return meetingByBigIntegers(corners, integers, crossingsOnly);
  }
  if (decision.spans || crossingsOnly) return decision.meeting;
  return meetingInHyperplane(wholeOf(corners, integers), corners);
}

Corners8 cornersOf(const CellCorners& a, const CellCorners& b) {
  return {a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]};
}

/// Whether all signs of these determinants are certain and the same: the corners of the one cell
/// lie on one side of the other's hyperplane.
bool onOneSide(const Determinants<double>& determinants, double error, Mask cell) {
  int side = 0;
  for (unsigned bit = 1; bit <= 0x80; bit <<= 1) {
    if ((cell & bit) != 0) continue;
    const double value = determinants.of(static_cast<Mask>(cell | bit));
    if (!(std::abs(value) > error)) return false;
    side += value > 0 ? 1 : -1;
  }
  return side == 4 || side == -4;
}

/// False if the corners of one cell are certainly not on both sides of the other's hyperplane: a
/// corner that is one of both lies in it.
bool mayCross(const Determinants<double>& determinants, double error, Mask cell,
              const Corners8& corners) {
  int maybeAbove = 0;
  int maybeBelow = 0;
  int both = 0;
  for (unsigned bit = 1; bit <= 0x80; bit <<= 1) {
    if ((cell & bit) != 0) continue;
    const Point4& corner = corners[static_cast<std::size_t>(std::countr_zero(bit))];
    bool shared = false;
    for (std::size_t i = 0; i < 8 && !shared; ++i) {
      shared = (cell >> i & 1U) != 0 && corners[i] == corner;
    }
    if (shared) continue;
    const double value = determinants.of(static_cast<Mask>(cell | bit));
    if (std::abs(value) <= error) {
      ++both;
    } else {
      ++(value > 0 ? maybeAbove : maybeBelow);
    }
  }
  return both >= 2 || (both == 1 && maybeAbove + maybeBelow > 0) ||
         (maybeAbove > 0 && maybeBelow > 0);
}

}  // namespace

std::optional<CellMeeting> meetingOf(const CellCorners& a, const CellCorners& b,
                                     bool crossingsOnly) {
  const Corners8 corners = cornersOf(a, b);
  std::array<std::array<double, 4>, 7> u;
  std::array<double, 4> largest{};
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t axis = 0; axis < 4; ++axis) {
      const auto index = static_cast<Eigen::Index>(axis);
      u[i][axis] = corners[i][index] - corners[7][index];
      largest[axis] = std::max(largest[axis], std::abs(u[i][axis]));
    }
  }
  // Each determinant is a sum of at most 5 * 24 products of one difference for each axis. With
  // u = 2^-53, a product of minors is computed with at most 9 roundings a term (2 * 2 for the
  // differences, 2 * 2 for the minors, 1), and summed with at most 3 + 4 more: the error is below
  // 120 * (17 u) * M to first order, with M the product of the largest differences. 4096 u M is
  // twice that.
  constexpr double kError = 4096 * 0x1p-53;
  constexpr double kLeast = 0x1p-900;  // below that, products could underflow
  const double product = largest[0] * largest[1] * largest[2] * largest[3];
  const double error = kError * product;
  const bool inRange = product > kLeast &&
                       product<1 / kLeast&& * std::ranges::min_element(largest)> 0x1p-400 &&
                       *std::ranges::max_element(largest) < 0x1p400;
  if (crossingsOnly && *std::ranges::min_element(largest) == 0) return std::nullopt;
  if (!inRange) return meetingByIntegers(corners, crossingsOnly);

  const Determinants<double> determinants(u);
  if (onOneSide(determinants, error, kMaskA) || onOneSide(determinants, error, kMaskB)) {
    return std::nullopt;
  }
  if (crossingsOnly && !(mayCross(determinants, error, kMaskA, corners) &&
                         mayCross(determinants, error, kMaskB, corners))) {
    return std::nullopt;
  }
  const auto sign = [&](Mask five) {
    const double value = determinants.of(five);
    return std::abs(value) > error ? signOf(value) : 2;
  };
  Collected collected;
  for (const Mask six : kSixes) {
    const Answer answer = answerOf(six, sign);
    if (answer == Answer::Unknown) return meetingByIntegers(corners, crossingsOnly);
    if (answer == Answer::No) continue;
    Mask support = 0;
    const Combination<double> combination = combinationOf(six, determinants, support);
    collected.add(pointOf(combination, corners), support);
  }
  if (!collected.any()) return std::nullopt;
  // No sign of a common point is 0, and so neither cell is flat.
  collected.meeting().crosses = collected.inside();
  return collected.meeting();
}

std::optional<CellMeeting> meetingRoundedOnce(const CellCorners& a, const CellCorners& b) {
  const Corners8 corners = cornersOf(a, b);
  return meetingByBigIntegers(corners, integersOf(corners), /*crossingsOnly=*/false);
}

}  // namespace t4d::measure
