#include "measure/cell_pair.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

namespace t4d::measure {
namespace {

using boost::multiprecision::cpp_int;
using model::Point3;
using model::Point4;

__extension__ using Int128 = __int128;

double ratio(Int128 p, Int128 q) {
  return static_cast<double>(static_cast<long double>(p) / static_cast<long double>(q));
}
double ratio(const cpp_int& p, const cpp_int& q) {
  return boost::multiprecision::cpp_rational(p, q).convert_to<double>();
}

/// What is known of two cells by the simplex method with integers (Bland's rule, and Edmonds'
/// division by the last pivot, which keeps the tableau whole): the program has eight weights, four
/// for the corners of each cell, and six equations.
template <class Number>
class Oracle {
 public:
  using Rows = std::array<std::array<std::int64_t, 4>, 8>;  // corners: four of a, four of b

  bool meets = false;
  double timeBegin = 0;
  double timeEnd = 0;

  explicit Oracle(const Rows& corners) : corners_(corners) {
    if (!start()) return;
    meets = true;
    timeBegin = optimum(+1);
    timeEnd = optimum(-1);
  }

 private:
  static constexpr std::size_t kVariables = 8;

  bool start() {
    // Columns: eight weights, six artificial variables, right side.
    rows_.assign(6, std::vector<Number>(kVariables + 7, 0));
    for (std::size_t r = 0; r < 4; ++r) {
      for (std::size_t i = 0; i < 8; ++i) rows_[r][i] = i < 4 ? corners_[i][r] : -corners_[i][r];
    }
    for (std::size_t i = 0; i < 8; ++i) rows_[i < 4 ? 4 : 5][i] = 1;
    for (std::size_t r = 0; r < 6; ++r) rows_[r][kVariables + r] = 1;
    rows_[4].back() = 1;
    rows_[5].back() = 1;
    basis_ = {8, 9, 10, 11, 12, 13};
    // The sum of the artificial variables, as reduced costs.
    std::vector<Number> cost(kVariables + 7, 0);
    for (std::size_t c = 0; c < cost.size(); ++c) {
      for (const auto& row : rows_) cost[c] -= row[c];
    }
    for (std::size_t c = kVariables; c < kVariables + 6; ++c) cost[c] = 0;
    minimise(cost, kVariables + 6);
    if (cost.back() != 0) return false;
    // Artificial variables that are left are 0: exchanged, or their equation says nothing.
    for (std::size_t r = 0; r < rows_.size();) {
      if (basis_[r] < kVariables) {
        ++r;
        continue;
      }
      std::size_t column = 0;
      while (column < kVariables && rows_[r][column] == 0) ++column;
      if (column == kVariables) {
        rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(r));
        basis_.erase(basis_.begin() + static_cast<std::ptrdiff_t>(r));
        continue;
      }
      if (rows_[r][column] < 0) {
        for (Number& value : rows_[r]) value = -value;
      }
      pivot(r, column, nullptr);
      ++r;
    }
    return true;
  }

  double optimum(int sign) {
    std::vector<Number> cost(kVariables + 7, 0);
    for (std::size_t c = 0; c < 4; ++c) cost[c] = Number(sign * corners_[c][3]) * divisor_;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Number factor = basis_[r] < 4 ? Number(sign * corners_[basis_[r]][3]) : Number(0);
      for (std::size_t c = 0; c < cost.size(); ++c) cost[c] -= factor * rows_[r][c];
    }
    minimise(cost, kVariables);
    return ratio(Number(-cost.back() * sign), divisor_);
  }

  void minimise(std::vector<Number>& cost, std::size_t columns) {
    for (;;) {
      std::size_t column = 0;
      while (column < columns && !(cost[column] < 0)) ++column;
      if (column == columns) return;
      std::size_t best = rows_.size();
      for (std::size_t r = 0; r < rows_.size(); ++r) {
        if (!(rows_[r][column] > 0)) continue;
        if (best == rows_.size()) {
          best = r;
          continue;
        }
        const Number left = rows_[r].back() * rows_[best][column];
        const Number right = rows_[best].back() * rows_[r][column];
        if (left < right || (left == right && basis_[r] < basis_[best])) best = r;
      }
      pivot(best, column, &cost);
    }
  }

  void pivot(std::size_t row, std::size_t column, std::vector<Number>* cost) {
    const Number p = rows_[row][column];
    const auto eliminate = [&](std::vector<Number>& other) {
      const Number factor = other[column];
      for (std::size_t c = 0; c < other.size(); ++c) {
        other[c] = (other[c] * p - factor * rows_[row][c]) / divisor_;
      }
    };
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (r != row) eliminate(rows_[r]);
    }
    if (cost != nullptr) eliminate(*cost);
    divisor_ = p;
    basis_[row] = column;
  }

  Rows corners_;
  std::vector<std::vector<Number>> rows_;
  std::vector<std::size_t> basis_;
  Number divisor_ = 1;
};

/// Cells with whole coordinates, scaled by a power of two.
struct Pair {
  Oracle<Int128>::Rows corners{};
  double scale = 1;

  CellCorners cell(std::size_t first) const {
    CellCorners cell;
    for (std::size_t i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        cell[i][k] = static_cast<double>(corners[first + i][static_cast<std::size_t>(k)]) * scale;
      }
    }
    return cell;
  }
};

class Pairs {
 public:
  explicit Pairs(unsigned seed) : random_(seed) {}

  /// Degenerate in the way of this number.
  Pair next(int way, int range) {
    Pair pair;
    auto& p = pair.corners;
    for (auto& corner : p) corner = {any(range), any(range), any(range), any(range)};
    switch (way % 12) {
      case 1:
        p[4] = p[0];
        break;  // a common corner
      case 2:
        p[4] = p[0], p[5] = p[1];
        break;  // a common edge
      case 3:
        p[4] = p[0], p[5] = p[1], p[6] = p[2];
        break;  // a common triangle
      case 4:   // one hyperplane of constant time
        for (auto& corner : p) corner[3] = 2;
        break;
      case 5:  // one slanted hyperplane
        for (auto& corner : p) corner[3] = corner[0] - 2 * corner[1] + corner[2];
        break;
      case 6:  // a corner in an edge of the other
        for (std::size_t k = 0; k < 4; ++k) p[1][k] = 2 * p[4][k] - p[0][k];
        break;
      case 7:  // a corner in a triangle
        for (std::size_t k = 0; k < 4; ++k) p[2][k] = 3 * p[4][k] - p[0][k] - p[1][k];
        break;
      case 8:  // a corner inside
        for (std::size_t k = 0; k < 4; ++k) {
          p[3][k] = 4 * p[4][k] - p[0][k] - p[1][k] - p[2][k];
        }
        break;
      case 9:  // two edges that cross
        for (std::size_t k = 0; k < 4; ++k) p[1][k] = p[4][k] + p[5][k] - p[0][k];
        break;
      case 10:  // one of them flat, or both
        for (std::size_t k = 0; k < 4; ++k) p[3][k] = p[0][k] + p[1][k] - p[2][k];
        if (any(1) > 0) p[7] = p[6];
        break;
      case 11:  // all in one plane
        for (auto& corner : p) corner[2] = corner[0], corner[3] = corner[1];
        break;
      default:
        break;
    }
    if (any(1) == 0) std::swap(p[0], p[3]), std::swap(p[4], p[6]);
    return pair;
  }
  std::int64_t any(int range) {
    return std::uniform_int_distribution<std::int64_t>(-range, range)(random_);
  }

 private:
  std::mt19937 random_;
};

template <class Number>
void expectAgreement(const Pair& pair, std::uint64_t& met, int number) {
  const Oracle<Number> oracle(pair.corners);
  for (const bool rounded : {false, true}) {
    if (rounded && number % 8 != 0) continue;  // slow
    const auto found = rounded ? meetingRoundedOnce(pair.cell(0), pair.cell(4))
                               : meetingOf(pair.cell(0), pair.cell(4));
    ASSERT_EQ(found.has_value(), oracle.meets);
    if (!found) continue;
    const double least = oracle.timeBegin * pair.scale;
    const double most = oracle.timeEnd * pair.scale;
    double size = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      size = std::max(size, std::abs(static_cast<double>(pair.corners[i][3]) * pair.scale));
    }
    ASSERT_NEAR(found->timeBegin, least, 1e-13 * size);
    ASSERT_NEAR(found->timeEnd, most, 1e-13 * size);
  }
  if (oracle.meets) ++met;
}

TEST(CellPair, AgreesWithExactArithmeticOnSmallNumbers) {
  Pairs pairs(1);
  std::uint64_t met = 0;
  for (int i = 0; i < 96000; ++i) {
    SCOPED_TRACE(i);
    expectAgreement<Int128>(pairs.next(i, 1 + i / 12 % 6), met, i);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(met, 20000U);
}

TEST(CellPair, AgreesWithExactArithmeticOnNumbersOfManyDigits) {
  Pairs pairs(2);
  std::uint64_t met = 0;
  for (int i = 0; i < 6000; ++i) {
    SCOPED_TRACE(i);
    Pair pair = pairs.next(i, i % 5 == 0 ? 1 << 20 : 1'000'000'000);
    pair.scale = std::ldexp(1, -30);
    expectAgreement<cpp_int>(pair, met, 8);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(met, 1000U);
}

TEST(CellPair, CellsOfAHyperplaneCoincideIfTheyFaceTheSameWayAndHaveAVolumeInCommon) {
  // The slices by a slanted hyperplane, t = x + 2 y - z, and by one of constant time.
  for (const Point3& slant : {Point3(1, 2, -1), Point3(0, 0, 0)}) {
    const auto cell = [&](const Point3& at) {
      CellCorners corners;
      const Point3 offsets[] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
      for (std::size_t i = 0; i < 4; ++i) {
        const Point3 place = at + offsets[i];
        corners[i] << place, slant.dot(place);
      }
      return corners;
    };
    const CellCorners one = cell({0, 0, 0});
    CellCorners other = cell({0.5, 0.25, 0.25});
    const auto same = meetingOf(one, other);
    ASSERT_TRUE(same);
    EXPECT_TRUE(same->coincides);
    std::swap(other[0], other[1]);
    const auto opposite = meetingOf(one, other);
    ASSERT_TRUE(opposite);
    EXPECT_FALSE(opposite->coincides);
    const auto corner = meetingOf(one, cell({4, 0, 0}));
    ASSERT_TRUE(corner);
    EXPECT_FALSE(corner->coincides);
  }
}

}  // namespace
}  // namespace t4d::measure
