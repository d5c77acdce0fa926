#include <cstring>

#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

template <class T>
std::vector<T> betweenRows(double fraction) {
  Attribute attribute = makeAttribute("a", Domain::Vertex, std::vector<T>{1, 10, 3, 20});
  attribute.components = 2;
  std::vector<T> row(2);
  interpolateRow(attribute, 0, 1, fraction, reinterpret_cast<std::byte*>(row.data()));
  return row;
}

TEST(Attributes, AQuarterOfTheWayIsNearTheFirstRow) {
  EXPECT_EQ(betweenRows<float>(0.25), (std::vector<float>{1.5F, 12.5F}));
  EXPECT_EQ(betweenRows<double>(0.25), (std::vector{1.5, 12.5}));
  EXPECT_EQ(betweenRows<std::int16_t>(0.75), (std::vector<std::int16_t>{1, 10}));
}

}  // namespace
}  // namespace t4d::model
