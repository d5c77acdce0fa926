#include "measure/hull_distance.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace t4d::measure {
namespace {

using model::Point3;
using model::Point4;

/// Points in a box about a place, at times of which many are equal, as those of layers are.
std::vector<Point4> hull(std::mt19937& random, const Point3& about) {
  std::uniform_real_distribution<double> place(-1, 1);
  std::uniform_int_distribution<int> count(1, 12);
  std::uniform_int_distribution<int> time(0, 4);
  std::vector<Point4> points(static_cast<std::size_t>(count(random)));
  for (Point4& point : points) {
    point << about + Point3(place(random), place(random), place(random)), 0.25 * time(random);
  }
  return points;
}

/// A point of the hull at a time: between one that is before and one that is after.
std::optional<Point3> pointAt(std::mt19937& random, const std::vector<Point4>& points,
                              double time) {
  std::uniform_real_distribution<double> weight(0, 1);
  Point4 before = Point4::Zero();
  Point4 after = Point4::Zero();
  double sumBefore = 0;
  double sumAfter = 0;
  for (const Point4& point : points) {
    const double w = std::pow(weight(random), 4);
    if (point[3] <= time) {
      before += w * point;
      sumBefore += w;
    }
    if (point[3] >= time) {
      after += w * point;
      sumAfter += w;
    }
  }
  if (sumBefore == 0 || sumAfter == 0) return std::nullopt;
  before /= sumBefore;
  after /= sumAfter;
  const double length = after[3] - before[3];
  const double s = length > 0 ? (time - before[3]) / length : 0;
  return (before + s * (after - before)).head<3>();
}

TEST(HullDistance, TheBoundOfTwoPointsIsNotAboveTheirDistance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1, 1);
  for (int round = 0; round < 1000; ++round) {
    std::vector<Point4> a(1);
    std::vector<Point4> b(1);
    for (auto* point : {&a[0], &b[0]}) *point << place(random), place(random), place(random), 0.5;
    const auto found = distanceOf(a, b, 100);
    ASSERT_TRUE(found);
    const Eigen::Matrix<long double, 3, 1> offset =
        a[0].head<3>().cast<long double>() - b[0].head<3>().cast<long double>();
    ASSERT_LE(static_cast<long double>(found->lowerBound), offset.norm()) << round;
    ASSERT_NEAR(found->lowerBound, found->distance, 1e-13);
  }
}

TEST(HullDistance, NoPointsAtEqualTimesAreNearerThanTheBoundAndSomeAreAsNear) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shift(-3, 3);
  std::uniform_real_distribution<double> someTime(0, 1);
  int apart = 0;
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(round);
    const Point3 far = round % 2 == 0 ? Point3(0, 0, 0) : Point3(1e6, -3e5, 7e4);
    const std::vector<Point4> a = hull(random, far);
    const std::vector<Point4> b =
        hull(random, far + Point3(shift(random), shift(random), shift(random)));
    const auto found = distanceOf(a, b);
    const auto byTime = [](const Point4& p, const Point4& q) { return p[3] < q[3]; };
    const auto [firstA, lastA] = std::ranges::minmax_element(a, byTime);
    const auto [firstB, lastB] = std::ranges::minmax_element(b, byTime);
    const double begin = std::max((*firstA)[3], (*firstB)[3]);
    const double end = std::min((*lastA)[3], (*lastB)[3]);
    ASSERT_EQ(found.has_value(), begin <= end);
    if (!found) continue;
    EXPECT_LE(found->lowerBound, found->distance);
    EXPECT_NEAR((found->pointA - found->pointB).norm(), found->distance, 1e-9);
    EXPECT_GE(found->time, begin);
    EXPECT_LE(found->time, end);
    for (int sample = 0; sample < 50; ++sample) {
      const double time = begin + someTime(random) * (end - begin);
      const auto p = pointAt(random, a, time);
      const auto q = pointAt(random, b, time);
      if (!p || !q) continue;
      EXPECT_GE((*p - *q).norm(), found->lowerBound - 1e-9);
    }
    if (found->distance < 1e-6) continue;
    ++apart;
    EXPECT_NEAR(found->lowerBound, found->distance, 1e-8 * found->distance + 1e-9);
    // With a smaller `enough`, the search may end earlier, but the bound holds.
    const auto enough = distanceOf(a, b, found->distance / 2);
    EXPECT_GT(enough->lowerBound, found->distance / 2);
    EXPECT_LE(enough->lowerBound, found->distance + 1e-9);
  }
  EXPECT_GT(apart, 500);
}

TEST(HullDistance, OfPointsThatPassEachOther) {
  // On lines that are 3 apart, past each other at t = 0.25.
  const std::vector<Point4> a = {{0, 0, 0, 0}, {4, 0, 0, 1}};
  const std::vector<Point4> b = {{2, 3, 0, 0}, {-2, 3, 0, 1}};
  const auto found = distanceOf(a, b);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->distance, 3, 1e-12);
  EXPECT_NEAR(found->time, 0.25, 1e-12);
}

}  // namespace
}  // namespace t4d::measure
