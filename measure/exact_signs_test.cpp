#include "measure/exact_signs.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace t4d::measure {
namespace {

using model::Point3;
__extension__ typedef __int128 Integer;

int signOf(Integer value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// Whole numbers up to 2^39 in magnitude, so that determinants fit in 128 bits.
class Whole {
 public:
  explicit Whole(unsigned seed) : random_(seed) {}
  std::int64_t upTo(std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(-most, most)(random_);
  }

 private:
  std::mt19937_64 random_;
};

TEST(ExactSigns, OfPlanesAreThoseOfWholeNumbers) {
  Whole whole(1);
  int zeros = 0;
  for (int round = 0; round < 200'000; ++round) {
    const std::int64_t most = round % 2 == 0 ? 3 : (std::int64_t{1} << 36);
    std::int64_t p[4][3];
    for (auto& point : p) {
      for (auto& c : point) c = whole.upTo(most);
    }
    if (round % 4 == 1) {
      // The last one in the plane of the others, or off it by one.
      const std::int64_t s = whole.upTo(3);
      const std::int64_t t = whole.upTo(3);
      for (int c = 0; c < 3; ++c)
        p[3][c] = p[0][c] + s * (p[1][c] - p[0][c]) + t * (p[2][c] - p[0][c]);
      p[3][round % 3] += whole.upTo(1);
    }
    Integer rows[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < 3; ++c) rows[i][c] = Integer{p[i + 1][c]} - p[0][c];
    }
    Integer det = 0;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3;
      const int e = (c + 2) % 3;
      det += rows[0][c] * (rows[1][d] * rows[2][e] - rows[1][e] * rows[2][d]);
    }
    Point3 points[4];
    // A power of two changes no sign, in the middle of the range or at its ends.
    const int exponent = round % 5 == 0 ? 260 : round % 5 == 1 ? -300 : -7;
    for (int i = 0; i < 4; ++i) {
      for (int c = 0; c < 3; ++c) points[i][c] = std::ldexp(static_cast<double>(p[i][c]), exponent);
    }
    EXPECT_EQ(orientation(points[0], points[1], points[2], points[3]), signOf(det));
    zeros += det == 0 ? 1 : 0;
    const Integer flat = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
    EXPECT_EQ(orientation(Point2(points[0].head<2>()), Point2(points[1].head<2>()),
                          Point2(points[2].head<2>())),
              signOf(flat));
  }
  EXPECT_GT(zeros, 10'000);
}

TEST(ExactSigns, SeeTheLastBit) {
  // Points on the diagonal, one of them moved by the smallest step that a double can.
  for (int k = 1; k < 200; ++k) {
    const double x = 0.1 * k;
    EXPECT_EQ(orientation(Point2(0.5, 0.5), Point2(12, 12), Point2(x, x)), 0);
    EXPECT_EQ(orientation(Point2(0.5, 0.5), Point2(12, 12), Point2(x, std::nextafter(x, 100))), 1);
    EXPECT_EQ(
        orientation(Point3(0.5, 0.5, 0), Point3(12, 12, 0), Point3(3, 3, 1), Point3(x, x, 0.3)), 0);
    EXPECT_EQ(
        orientation(Point3(0.5, 0.5, 0), Point3(12, 12, 0), Point3(3, 3, 1),
                    Point3(x, std::nextafter(x, 0), 0.3)),
        orientation(Point3(0.5, 0.5, 0), Point3(12, 12, 0), Point3(3, 3, 1), Point3(1, 0, 0)));
  }
}

}  // namespace
}  // namespace t4d::measure
