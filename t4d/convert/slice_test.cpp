#include "t4d/convert/slice.h"

#include <random>

#include <gtest/gtest.h>

#include "t4d/convert/flipbook.h"
#include "t4d/model/units.h"

namespace t4d::convert {
namespace {

TEST(Hyperplane, BasisOfAnAxisIsTheOtherAxesInOrder) {
  for (int axis = 0; axis < 4; ++axis) {
    const HyperplaneBasis basis = basisOf(Hyperplane::across(axis, 2));
    int row = 0;
    for (int other = 0; other < 4; ++other) {
      if (other == axis) continue;
      EXPECT_EQ(basis.axes.row(row++).transpose(), Eigen::Vector4d(Eigen::Vector4d::Unit(other)));
    }
    EXPECT_EQ(basis.rightHanded, axis % 2 == 1);
  }
}

TEST(Hyperplane, BasisIsOrthonormalAndLiesInTheHyperplane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 500; ++i) {
    Hyperplane hyperplane{{number(random), number(random), number(random), number(random)}, 0};
    if (i % 5 == 0) hyperplane.normal[i % 4] *= 1e-12;
    const HyperplaneBasis basis = basisOf(hyperplane);
    EXPECT_LT((basis.axes * basis.axes.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT((basis.axes * hyperplane.normal.normalized()).norm(), 1e-12);
  }
}

TEST(Hyperplane, ZeroAndNonFiniteNormalsAreRefused) {
  EXPECT_FALSE(checkHyperplane({Eigen::Vector4d::Zero(), 1}));
  EXPECT_FALSE(checkHyperplane({{1, 0, 0, std::numeric_limits<double>::infinity()}, 1}));
  EXPECT_TRUE(checkHyperplane({{0, 0, 0, 1e-5}, 1}));
}

/// The 4-simplex at the origin and the unit points, with an attribute per vertex: t itself.
model::Mesh pentachoron() {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  model::Slab slab;
  slab.timeEnd = 1;
  slab.connectivity = connectivity;
  slab.vertices = {model::Point4::Zero(), model::Point4::UnitX(), model::Point4::UnitY(),
                   model::Point4::UnitZ(), model::Point4::UnitW()};
  slab.attributes = {
      model::makeAttribute<double>("t", model::Domain::Vertex, {0, 0, 0, 0, 1}),
      model::makeAttribute<std::uint8_t>("corner", model::Domain::Vertex, {0, 1, 2, 3, 4}),
      model::makeAttribute<std::int16_t>("cell", model::Domain::Cell, {10, 11, 12, 13, 14})};
  model::Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

TEST(Slice, PentachoronHasTheSimplexShrinkingToItsApex) {
  model::Mesh mesh = pentachoron();
  for (const double t : {0.0, 0.25, 0.5, 0.9}) {
    const auto slice = sliceAtTime(mesh, t);
    ASSERT_TRUE(slice);
    EXPECT_EQ(slice->mesh.vertices.size(), 4U);
    EXPECT_EQ(slice->mesh.triangles.size(), 4U);
    EXPECT_TRUE(isClosed(slice->mesh));
    EXPECT_NEAR(signedVolume(slice->mesh), std::pow(1 - t, 3) / 6, 1e-15);
  }
}

TEST(Slice, TheSameInEveryDirection) {
  model::Mesh mesh = pentachoron();
  for (int axis = 0; axis < 3; ++axis) {
    const auto section = slice(mesh, Hyperplane::across(axis, 0.25));
    EXPECT_TRUE(isClosed(section->mesh));
    EXPECT_NEAR(signedVolume(section->mesh), std::pow(0.75, 3) / 6, 1e-15);
  }
}

TEST(Slice, ALongerNormalIsTheSameHyperplane) {
  model::Mesh mesh = pentachoron();
  const auto one = slice(mesh, {{1, 1, 1, 1}, 0.5});
  const auto ten = slice(mesh, {{10, 10, 10, 10}, 5});
  EXPECT_NEAR(signedVolume(one->mesh), signedVolume(ten->mesh), 1e-15);
  EXPECT_GT(signedVolume(one->mesh), 0);
}

TEST(Slice, VertexAttributesAreInterpolatedAndCellAttributesKept) {
  model::Mesh mesh = pentachoron();
  const auto slice = sliceAtTime(mesh, 0.25);
  ASSERT_EQ(slice->mesh.attributes.size(), 3U);
  const model::Attribute& t = slice->mesh.attributes[0];
  ASSERT_EQ(t.rows(), slice->mesh.vertices.size());
  for (std::size_t i = 0; i < t.rows(); ++i) {
    double value = 0;
    std::memcpy(&value, t.row(i), sizeof value);
    EXPECT_DOUBLE_EQ(value, 0.25);
  }
  EXPECT_EQ(slice->mesh.attributes[2].rows(), slice->mesh.triangles.size());
  EXPECT_TRUE(slice->losses.empty());
}

TEST(Slice, TimeOutsideSaysTheRange) {
  model::Mesh mesh = pentachoron();
  for (const double t : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    const auto slice = sliceAtTime(mesh, t);
    ASSERT_FALSE(slice);
    EXPECT_NE(slice.error().message.find("lasts from 0 to 1"), std::string::npos);
  }
}

TEST(Slice, MissingTheMeshIsEmpty) {
  model::Mesh mesh = pentachoron();
  const auto section = slice(mesh, Hyperplane::across(0, 5));
  ASSERT_TRUE(section);
  EXPECT_TRUE(section->mesh.triangles.empty());
}

TEST(EvenTimes, BothEndsAreExact) {
  const auto times = evenTimes(0.1, 0.7, 7);
  EXPECT_EQ(times.size(), 7U);
  EXPECT_EQ(times.front(), 0.1);
  EXPECT_EQ(times.back(), 0.7);
  EXPECT_EQ(evenTimes(3, 9, 1), std::vector<double>{3});
}

TEST(Units, MillimetresAndInches) {
  EXPECT_EQ(model::metresPer("mm"), 0.001);
  EXPECT_EQ(model::metresPer("in"), 0.0254);
  EXPECT_FALSE(model::metresPer("cubit"));
}

}  // namespace
}  // namespace t4d::convert
