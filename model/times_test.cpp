#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Times, StepsOfADecimalEndAtTheDecimal) {
  EXPECT_EQ(steppedTime(0, 0.7, 3), 2.1);
  EXPECT_EQ(steppedTime(0, 0.1, 3), 0.3);
  EXPECT_EQ(steppedTime(0.1, 0.2, 1), 0.3);
  EXPECT_EQ(steppedTime(-1.1, 0.1, 8), -0.3);
  EXPECT_EQ(steppedTime(1e9, 1e-6, 1), 1000000000.000001);
  EXPECT_EQ(steppedTimes(0, 0.1, 4), (std::vector<double>{0, 0.1, 0.2, 0.3}));
}

TEST(Times, EvenTimesOfDecimalsAreDecimals) {
  EXPECT_EQ(evenTimes({0, 1}, 11),
            (std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1}));
  EXPECT_EQ(evenTimes({-1, 1}, 5), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(evenTimes({2.1, 0}, 4), (std::vector<double>{2.1, 1.4, 0.7, 0}));
  EXPECT_EQ(evenTimes({3, 9}, 1), std::vector<double>{3});
  EXPECT_TRUE(evenTimes({3, 9}, 0).empty());
  EXPECT_EQ(dividedTime({0.1, 0.3}, 3, 2), 0.4);
}

TEST(Times, BothEndsAreExactWhateverTheyAre) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-300, 300);
  for (int i = 0; i < 1000; ++i) {
    const TimeSpan span{-std::pow(10, exponent(random)), std::pow(10, exponent(random))};
    const auto times = evenTimes(span, 7);
    EXPECT_EQ(times.front(), span.begin);
    EXPECT_EQ(times.back(), span.end);
    EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  }
}

TEST(Times, AreRoundedOnce) {
  // Thousandths as whole numbers, and one division.
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const long long begin = static_cast<long long>(random() % 100'000) - 50'000;
    const long long step = 1 + static_cast<long long>(random() % 10'000);
    const std::uint64_t k = random() % 1000;
    const double expected = static_cast<double>(begin + step * static_cast<long long>(k)) / 1000;
    EXPECT_EQ(steppedTime(static_cast<double>(begin) / 1000, static_cast<double>(step) / 1000, k),
              expected);
    const double third = static_cast<double>(begin) / 3;
    EXPECT_EQ(dividedTime({0, static_cast<double>(begin)}, 1, 3), third);
  }
  EXPECT_EQ(dividedTime({0, 100}, 1, 65), 100.0 / 65);
}

TEST(Times, OutOfReachOfExactArithmeticTheyAreDoubles) {
  EXPECT_EQ(steppedTime(1e30, 1e-30, 5), 1e30);
  EXPECT_EQ(steppedTime(0, 1e300, 3), 3e300);
  EXPECT_EQ(steppedTime(0, 1e308, 3), kInfinity);
  EXPECT_EQ(dividedTime({-1e308, 1e308}, 1, 2), 0);
  EXPECT_EQ(dividedTime({1e30, -1e-30}, 1, 2), 5e29);
  EXPECT_TRUE(std::isnan(steppedTime(0, kInfinity, 0)));
}

/// A mesh that lasts from layer to layer, of which only the times matter.
Mesh meshOf(const std::vector<double>& layers) {
  Mesh mesh;
  for (std::size_t i = 0; i + 1 < layers.size(); ++i) {
    Slab slab;
    slab.timeBegin = layers[i];
    slab.timeEnd = layers[i + 1];
    slab.connectivity = std::make_shared<Connectivity>();
    EXPECT_TRUE(mesh.put(slab));
  }
  return mesh;
}

TEST(Times, ATimeJustOffALayerOrAnEndIsIt) {
  const Mesh mesh = meshOf({0, 0, 0.7, 1.4, 3 * 0.7, 3 * 0.7});
  ASSERT_NE(3 * 0.7, 2.1);
  EXPECT_EQ(timeWithin(mesh, 2.1), 3 * 0.7);
  EXPECT_EQ(timeWithin(mesh, -4e-16), 0);
  for (const double layer : {0.7, 1.4}) {
    double below = layer;
    double above = layer;
    for (int ulps = 0; ulps <= kSameTimeUlps; ++ulps) {
      EXPECT_EQ(timeWithin(mesh, below), layer);
      EXPECT_EQ(timeWithin(mesh, above), layer);
      below = std::nextafter(below, -kInfinity);
      above = std::nextafter(above, kInfinity);
    }
    EXPECT_EQ(timeWithin(mesh, layer + 1e-14), layer + 1e-14);
    EXPECT_EQ(timeWithin(mesh, layer - 1e-14), layer - 1e-14);
  }
}

TEST(Times, OutsideTheMeshThereIsNone) {
  const Mesh mesh = meshOf({0, 1});
  for (const double time : {-1e-14, 1 + 1e-14, kInfinity, -kInfinity, std::nan("")}) {
    EXPECT_FALSE(timeWithin(mesh, time));
    EXPECT_FALSE(timeWithin(timeSpanOf(mesh), time));
  }
  EXPECT_FALSE(timeWithin(Mesh(), 0));
}

TEST(Times, LayersNearerThanTheToleranceAreToldApart) {
  const double next = std::nextafter(1, 2);
  const Mesh mesh = meshOf({1, next, std::nextafter(next, 2)});
  for (const double layer : {1.0, next, std::nextafter(next, 2)}) {
    EXPECT_EQ(timeWithin(mesh, layer), layer);
    EXPECT_EQ(timeWithin({1, next}, std::min(layer, next)), std::min(layer, next));
  }
  const double largest = std::numeric_limits<double>::max();
  EXPECT_EQ(timeWithin({-largest, largest}, 0), 0);
}

}  // namespace
}  // namespace t4d::model
