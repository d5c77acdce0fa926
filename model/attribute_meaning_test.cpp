#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

Attribute rowOf(const Eigen::Vector3d& row, const std::string& name = "v") {
  Attribute attribute =
      makeAttribute(name, Domain::Vertex, std::vector<double>{row[0], row[1], row[2]});
  attribute.components = 3;
  return attribute;
}

Eigen::Vector3d valueOf(const Attribute& attribute) {
  Eigen::Vector3d row;
  std::memcpy(row.data(), attribute.values.data(), sizeof(double) * 3);
  return row;
}

Transform randomMap(std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> power(-60, 60);
  Transform by;
  for (double& entry : by.space.reshaped()) entry = normal(random);
  by.space *= std::pow(10, power(random));
  by.timeScale = std::pow(10, power(random) / 10);
  by.timeShift = normal(random);
  return by;
}

/// What holds for points holds for what is made of points.
TEST(AttributeMeaning, FollowsPointsUnderAnyMap) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 1000; ++trial) {
    SCOPED_TRACE(trial);
    const Transform by = randomMap(random);
    Point4 p;
    Point4 q;
    for (double& number : p) number = normal(random);
    for (double& number : q) number = normal(random);
    const Point4 moved = by(q) - by(p);
    const double size = by.space.cwiseAbs().maxCoeff() + std::abs(by(p).head<3>().maxCoeff());

    Attribute step = rowOf((q - p).head<3>());
    ASSERT_TRUE(mapValues(step, {"vector", "length"}, by));
    EXPECT_NEAR((valueOf(step) - moved.head<3>()).norm(), 0, 1e-13 * size);

    Attribute velocity = rowOf((q - p).head<3>() / (q - p)[3], "velocity");
    ASSERT_TRUE(mapValues(velocity, meaningOf(velocity, {}), by));
    EXPECT_TRUE(valueOf(velocity).isApprox(valueOf(step) / ((q - p)[3] * by.timeScale), 1e-12));

    Attribute point = rowOf(p.head<3>());
    ASSERT_TRUE(mapValues(point, {"point", ""}, by));
    EXPECT_EQ(valueOf(point), by(p).head<3>());

    const Eigen::Vector3d across(normal(random), normal(random), normal(random));
    Attribute perpendicular = rowOf((q - p).head<3>().cross(across).normalized());
    const double side = valueOf(perpendicular).dot(p.head<3>());
    ASSERT_TRUE(mapValues(perpendicular, {"normal", ""}, by));
    EXPECT_NEAR(valueOf(perpendicular).norm(), 1, 1e-14);
    EXPECT_NEAR(valueOf(perpendicular).dot(valueOf(step).normalized()), 0, 1e-11);
    EXPECT_EQ(valueOf(perpendicular).dot(by.space.leftCols<3>() * p.head<3>()) > 0, side > 0);

    for (const char* kind : {"label", "color", "scalar", ""}) {
      Attribute same = rowOf(p.head<3>());
      const auto mapped = mapValues(same, {kind, ""}, by);
      ASSERT_TRUE(mapped);
      EXPECT_FALSE(*mapped);
      EXPECT_EQ(valueOf(same), p.head<3>());
    }
  }
}

TEST(AttributeMeaning, UnitsScaleOnlyWhereAllDirectionsDo) {
  Transform twice;
  twice.space.leftCols<3>() *=
      2 * Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  twice.timeScale = 4;
  const auto mapped = [&](const char* kind, const char* unit) {
    Attribute attribute = rowOf({2, 0, 0});
    EXPECT_TRUE(mapValues(attribute, {kind, unit}, twice));
    return valueOf(attribute);
  };
  EXPECT_TRUE(mapped("vector", "").isApprox(Eigen::Vector3d(0, 4, 0), 1e-15));
  EXPECT_TRUE(mapped("vector", "length/time").isApprox(Eigen::Vector3d(0, 1, 0), 1e-15));
  EXPECT_TRUE(mapped("vector", "length/time^2").isApprox(Eigen::Vector3d(0, 0.25, 0), 1e-15));
  EXPECT_TRUE(mapped("vector", "N").isApprox(Eigen::Vector3d(0, 2, 0), 1e-15));
  EXPECT_TRUE(mapped("scalar", "length^3/time").isApprox(Eigen::Vector3d(4, 0, 0), 1e-15));
  EXPECT_TRUE(mapped("scalar", "1/time").isApprox(Eigen::Vector3d(0.5, 0, 0), 1e-15));
  EXPECT_EQ(mapped("scalar", "mm"), Eigen::Vector3d(2, 0, 0));

  Transform stretch;
  stretch.space(0, 0) = 3;
  for (const auto& [kind, unit] : {std::pair{"vector", "N"}, {"scalar", "length"}}) {
    Attribute attribute = rowOf({2, 0, 0});
    const auto refused = mapValues(attribute, {kind, unit}, stretch);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unsupported);
  }
}

TEST(AttributeMeaning, IsThatOfTheFileBeforeThatOfTheRegistry) {
  const Attribute velocity = rowOf({1, 0, 0}, "velocity");
  EXPECT_EQ(meaningOf(velocity, {}), (AttributeMeaning{"vector", "length/time"}));
  EXPECT_EQ(meaningOf(velocity, {{"velocity", {"label", ""}}}), (AttributeMeaning{"label", ""}));
  EXPECT_EQ(meaningOf(rowOf({1, 0, 0}, "displacement"), {}),
            (AttributeMeaning{"vector", "length"}));
  Attribute ofCells = velocity;
  ofCells.domain = Domain::Cell;
  EXPECT_EQ(meaningOf(ofCells, {}), AttributeMeaning{});
  EXPECT_EQ(powersOf("length^2/time").length, 2);
  EXPECT_EQ(powersOf("kg*length/time^2").time, -2);
  for (const char* none : {"", "N", "mm/s", "length^x", "length//time", "length^99", "lengthy"}) {
    EXPECT_EQ(powersOf(none).length, 0) << none;
  }
}

TEST(AttributeMeaning, WhatCannotFollowIsRefused) {
  Transform by;
  by.space *= 1e200;
  Attribute huge = rowOf({1e200, 0, 0});
  EXPECT_EQ(mapValues(huge, {"vector", ""}, by).error().code, ErrorCode::InvalidInput);
  by.space.setIdentity();
  by.space.leftCols<3>() *= 1e-200;
  Attribute tiny = rowOf({1e-200, 0, 0});
  EXPECT_EQ(mapValues(tiny, {"vector", ""}, by).error().code, ErrorCode::InvalidInput);
  Attribute whole = makeAttribute("n", Domain::Cell, std::vector<std::int32_t>{1, 2});
  EXPECT_EQ(mapValues(whole, {"scalar", "length"}, by).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(mapValues(whole, {"vector", ""}, by).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(mapValues(whole, {"tensor", ""}, by).error().code, ErrorCode::Unsupported);
  whole = makeAttribute("n", Domain::Cell, std::vector<std::int32_t>{1, 2, 3});
  whole.components = 3;
  Attribute flat = makeAttribute("n", Domain::Cell, std::vector{1.0, 2.0});
  flat.components = 2;
  for (Attribute* attribute : {&whole, &flat}) {
    EXPECT_EQ(mapValues(*attribute, {"vector", ""}, by).error().code, ErrorCode::Unsupported);
  }
  EXPECT_TRUE(mapValues(whole, {"label", ""}, by));
}

TEST(AttributeMeaning, WhatDoesNotMoveKeepsAnyAttribute) {
  Attribute whole = makeAttribute("n", Domain::Cell, std::vector<std::int32_t>{1, 2, 3});
  whole.components = 3;
  // Nothing changes, whatever the kind.
  for (const char* kind : {"scalar", "vector", "point", "normal", "of another version"}) {
    Attribute same = whole;
    const auto changed = mapValues(same, {kind, "length/time"}, {});
    ASSERT_TRUE(changed) << kind;
    EXPECT_FALSE(*changed) << kind;
    EXPECT_EQ(same, whole) << kind;
  }
  // Another speed is nothing to places and directions.
  Transform slower;
  slower.timeScale = 2;
  for (const char* kind : {"point", "normal"}) {
    Attribute same = whole;
    const auto changed = mapValues(same, {kind, "length/time"}, slower);
    ASSERT_TRUE(changed) << kind;
    EXPECT_FALSE(*changed) << kind;
    EXPECT_EQ(same, whole) << kind;
  }
}

TEST(Transform, ADeterminantIsSmallOnlyForItsMatrix) {
  const auto linear = [](std::initializer_list<double> rows) {
    Transform by;
    auto entry = rows.begin();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) by.space(row, column) = *entry++;
    }
    return by;
  };
  EXPECT_FALSE(linear({1, 1e9, 0, 0, 1, 0, 0, 0, 1}).flattens());
  EXPECT_FALSE(linear({1e6, 0, 0, 0, 1e-3, 0, 0, 0, 1e-3}).flattens());
  EXPECT_FALSE(linear({1e-200, 0, 0, 0, 1e-200, 0, 0, 0, 1e-200}).flattens());
  EXPECT_TRUE(linear({1e-200, 0, 0, 0, 1e-200, 0, 0, 0, -1e-200}).mirrors());
  EXPECT_TRUE(linear({1e200, 0, 0, 0, 1e200, 0, 0, 0, -1e200}).mirrors());
  EXPECT_TRUE(linear({1, 2, 3, 4, 5, 6, 7, 8, 9}).flattens());
  EXPECT_TRUE(linear({.1, .2, .3, .4, .5, .6, .7, .8, .9}).flattens());
  EXPECT_TRUE(linear({1, 0, 0, 0, 1, 0, 0, 0, 0}).flattens());
  EXPECT_TRUE(linear({0, 0, 0, 0, 0, 0, 0, 0, 0}).flattens());
}

}  // namespace
}  // namespace t4d::model
