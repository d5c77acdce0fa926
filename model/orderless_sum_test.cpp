#include "model/orderless_sum.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

TEST(OrderlessSum, IsTheSameForAnyOrderAndGrouping) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::vector<double> values;
  for (int i = 0; i < 500; ++i) values.push_back(std::ldexp(mantissa(random), i % 180 - 90));
  OrderlessSum whole;
  for (const double value : values) whole.add(value);
  for (const std::size_t parts : {2, 7, 500}) {
    std::ranges::shuffle(values, random);
    OrderlessSum joined;
    for (std::size_t part = 0; part < parts; ++part) {
      OrderlessSum one;
      for (std::size_t i = part; i < values.size(); i += parts) one.add(values[i]);
      for (const double term : one.terms()) joined.add(term);
    }
    EXPECT_EQ(joined.value(), whole.value());
    EXPECT_EQ(joined.terms(), whole.terms());
  }
}

TEST(OrderlessSum, IsRoundedOnce) {
  OrderlessSum sum;
  for (const double value : {1e100, 1.0, 1e-100, -1e100}) sum.add(value);
  EXPECT_EQ(sum.value(), 1);
  EXPECT_EQ(sum.terms(), (std::vector<double>{1, 1e-100}));
  OrderlessSum other;
  other.add(std::numeric_limits<double>::denorm_min());
  sum.add(other);
  EXPECT_EQ(sum.terms().back(), std::numeric_limits<double>::denorm_min());
}

TEST(OrderlessSum, KeepsWhatIsNotFinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  OrderlessSum sum;
  for (const double value : {1.0, kInfinity, -3e300}) sum.add(value);
  EXPECT_EQ(sum.value(), kInfinity);
  sum.add(-kInfinity);
  EXPECT_TRUE(std::isnan(sum.value()));
}

}  // namespace
}  // namespace t4d::model
