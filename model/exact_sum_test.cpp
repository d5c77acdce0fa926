#include "model/exact_sum.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "t4d/surface.h"

namespace t4d::model {
namespace {

using Factor = ExactSum::Factor;

void add(ExactSum& sum, std::initializer_list<double> factors, bool subtract = false) {
  std::vector<Factor> all;
  for (const double factor : factors) all.emplace_back(factor);
  std::vector<const Factor*> pointers;
  for (const Factor& factor : all) pointers.push_back(&factor);
  sum.add(pointers, subtract);
}

TEST(ExactSum, KeepsWhatCancelsInDoubles) {
  ExactSum sum;
  add(sum, {1e300, 1e300, 1e300, 1e300});
  add(sum, {5e-324, 5e-324, 5e-324, 5e-324});
  add(sum, {1e300, 1e300, 1e300, 1e300}, /*subtract=*/true);
  EXPECT_EQ(sum.sign(), 1);
  EXPECT_EQ(sum.dividedBy(1), 0);
  add(sum, {5e-324, -5e-324, 5e-324, 5e-324});
  EXPECT_EQ(sum.sign(), 0);
  add(sum, {-3, 0.5});
  EXPECT_EQ(sum.sign(), -1);
  EXPECT_EQ(sum.dividedBy(2), -0.75);
}

TEST(ExactSum, IsTheSumOfIntegers) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 200; ++round) {
    ExactSum sum;
    ExactSum other;
    std::int64_t expected = 0;
    for (int i = 0; i < 50; ++i) {
      const auto a = static_cast<std::int64_t>(random() % 2001) - 1000;
      const auto b = static_cast<std::int64_t>(random() % 2001) - 1000;
      const auto c = static_cast<std::int64_t>(random() % 2001) - 1000;
      add(i % 3 == 0 ? other : sum, {double(a), double(b), double(c)}, i % 2 == 0);
      expected += (i % 2 == 0 ? -1 : 1) * a * b * c;
    }
    sum.add(other);
    EXPECT_EQ(sum.dividedBy(1), static_cast<double>(expected));
    EXPECT_EQ(sum.sign(), (expected > 0) - (expected < 0));
  }
}

TEST(ExactSum, IsNotANumberOfWhatIsNotFinite) {
  ExactSum sum;
  add(sum, {std::numeric_limits<double>::infinity(), 1});
  EXPECT_EQ(sum.sign(), 0);
  EXPECT_TRUE(std::isnan(sum.dividedBy(1)));
}

TEST(DeterminantSign, IsThatOfTheProductAtAnyScale) {
  for (const double scale : {1e-300, 1e-100, 1.0, 1e100, 1e300}) {
    Eigen::Matrix4d matrix = scale * Eigen::Matrix4d::Identity();
    EXPECT_EQ(determinantSign(matrix), 1);
    matrix.row(1).swap(matrix.row(2));
    EXPECT_EQ(determinantSign(matrix), -1);
    matrix.row(3) = matrix.row(0);
    EXPECT_EQ(determinantSign(matrix), 0);
  }
}

/// A tetrahedron with corners at 0 and along each axis.
TriangleMesh corner(double size) {
  return {{Point3::Zero(), size * Point3::UnitX(), size * Point3::UnitY(), size * Point3::UnitZ()},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
          {}};
}

TEST(SignedVolume, IsTheScaledVolumeAtAnyScale) {
  for (int exponent = -1000; exponent <= 1000; exponent += 50) {
    const TriangleMesh mesh = corner(std::ldexp(1.0, exponent));
    EXPECT_EQ(signedVolume(mesh), std::ldexp(1.0 / 6, 3 * exponent)) << exponent;
  }
}

TEST(SignedVolume, OfAShellIsTheDifferenceToTheLastDigits) {
  // Two octahedra, the larger one inside out. The first corner of each triangle is on one axis, so
  // that a single term of its determinant is not 0.
  const double step = std::ldexp(1.0, -40);
  const double expected = -4 * step * (1 + step + step * step / 3);
  for (int first = 0; first < 3; ++first) {
    TriangleMesh mesh;
    for (const double size : {1.0, 1 + step}) {
      const auto begin = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
          mesh.vertices.emplace_back(sign * size * Point3::Unit(axis));
        }
      }
      for (unsigned signs = 0; signs < 8; ++signs) {
        Triangle triangle;
        for (unsigned i = 0; i < 3; ++i) {
          const unsigned axis = (static_cast<unsigned>(first) + i) % 3;
          triangle[i] = begin + 2 * axis + (signs >> axis & 1U);
        }
        const bool turned = (std::popcount(signs) % 2 != 0) != (size != 1);
        if (turned) std::swap(triangle[1], triangle[2]);
        mesh.triangles.push_back(triangle);
      }
    }
    EXPECT_NEAR(signedVolume(mesh), expected, 1e-15 * step) << first;
  }
}

TEST(SignedVolume, SurvivesACoordinateFarAway) {
  TriangleMesh mesh = corner(1);
  // A pyramid of height 1e20 over the triangle z = 0, with a spike that leaves the volume as it is.
  for (const double far : {1e20, 1e70, 1e300}) {
    mesh.vertices[3] = {far, far, 1};
    EXPECT_DOUBLE_EQ(signedVolume(mesh), 1.0 / 6) << far;
  }
}

}  // namespace
}  // namespace t4d::model
