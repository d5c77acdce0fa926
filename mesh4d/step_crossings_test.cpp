#include "mesh4d/step_crossings.h"

#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/cap.h"
#include "model/parallel.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {
namespace {

using fixtures::translated;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;

std::vector<Point3> between(const TriangleMesh& solid, const std::vector<Point3>& to, double s) {
  std::vector<Point3> places;
  for (std::size_t i = 0; i < to.size(); ++i) {
    places.emplace_back((1 - s) * solid.vertices[i] + s * to[i]);
  }
  return places;
}

/// Whether a solid crosses itself at the fraction s of the way.
bool crossesAt(const TriangleMesh& solid, const std::vector<Point3>& to, double s) {
  return !checkNoSelfIntersection({between(solid, to, s), solid.triangles, {}});
}

/// One step from time 0 to 1.
SweepReport sweptStep(const TriangleMesh& solid, const std::vector<Point3>& to) {
  model::NullSink sink;
  const auto report = sweep(solid, model::StoredKeys({{0, solid.vertices}, {1, to}}),
                            {{}, CapMethod::Cone, PrismSplit::Fourteen, {}}, sink);
  if (!report) {
    ADD_FAILURE() << report.error().text();
    return {};
  }
  EXPECT_TRUE(report->soughtCrossings);
  return *report;
}

/// The place of a crossing is in both triangles, so within the box of each.
void expectInBoth(const StepCrossing& crossing, const TriangleMesh& solid,
                  const std::vector<Point3>& to) {
  constexpr double kRounding = 1e-6;
  const auto places = between(solid, to, crossing.at);
  for (const std::uint32_t number : crossing.triangles) {
    model::Bounds3 box;
    for (const std::uint32_t corner : solid.triangles[number]) box.add(places[corner]);
    EXPECT_LE((box.min - crossing.place).maxCoeff(), kRounding) << number;
    EXPECT_LE((crossing.place - box.max).maxCoeff(), kRounding) << number;
  }
}

template <class Map>
std::vector<Point3> mapped(const TriangleMesh& solid, const Map& map) {
  std::vector<Point3> places;
  for (const Point3& p : solid.vertices) places.emplace_back(map(p));
  return places;
}

/// A plate in the shape of a U that lies on its side: below z = 0 the body from x = 0 to 10, above
/// or below it, at `height`, a flap from x = 9.5 back to `end`.
TriangleMesh plateWithFlap(double height, double end) {
  // Its cross-section in x and z, counter-clockwise seen from -y, in columns of two.
  constexpr int kColumns = 12;
  TriangleMesh mesh;
  for (const double y : {0.0, 4.0}) {
    for (int i = 0; i < kColumns; ++i) {
      for (const double outer : {0.0, 1.0}) {
        // On the body, on the way up or down, and back on the flap.
        const double away = height > 0 ? outer : 1 - outer;
        const double x = i < 5 ? 2.0 * i : i < 7 ? 10 + away : 9.5 + (end - 9.5) * (i - 7) / 4.0;
        const double lift = i < 5 ? 0 : i < 7 ? (i - 4) / 3.0 : 1;
        const double z = i < 5 ? -outer : lift * height + (i < 7 ? 0 : std::copysign(away, height));
        mesh.vertices.emplace_back(x, y, z);
      }
    }
  }
  const auto at = [](int side, int column, int outer) {
    return static_cast<std::uint32_t>(2 * (kColumns * side + column) + outer);
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int i = 0; i + 1 < kColumns; ++i) {
    quad(at(0, i, 1), at(0, i + 1, 1), at(0, i + 1, 0), at(0, i, 0));
    quad(at(1, i, 0), at(1, i + 1, 0), at(1, i + 1, 1), at(1, i, 1));
    quad(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
    quad(at(1, i, 1), at(1, i + 1, 1), at(0, i + 1, 1), at(0, i, 1));
  }
  quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
  quad(at(0, kColumns - 1, 1), at(1, kColumns - 1, 1), at(1, kColumns - 1, 0),
       at(0, kColumns - 1, 0));
  return mesh;
}

TEST(StepCrossings, AffineMapsHaveNone) {
  // Maps between two affine maps are affine, too; with these, none is singular.
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  for (const auto& solid : fixtures::allSolids()) {
    for (const double degrees : {0.0, 5.0, 85.0, 150.0}) {
      SCOPED_TRACE(solid.name + " " + std::to_string(degrees));
      const Eigen::Matrix3d turn = Eigen::AngleAxisd(degrees * M_PI / 180, axis).toRotationMatrix();
      const auto to = mapped(solid.mesh, [&](const Point3& p) -> Point3 {
        return 0.7 * (turn * p) + Point3(100, 0.3, -7);
      });
      EXPECT_EQ(sweptStep(solid.mesh, to).crossingPairs, 0U);
    }
    if (solid.mesh.triangles.size() > 2000) continue;
    const auto point = mapped(solid.mesh, [](const Point3&) -> Point3 { return {1e6, 1, 2}; });
    EXPECT_EQ(sweptStep(solid.mesh, point).crossingPairs, 0U) << solid.name;
  }
}

TEST(StepCrossings, DoNotDependOnTheNumberOfThreads) {
  // A solid turned inside out and about itself: more pairs than are tested at a time.
  const TriangleMesh solid = fixtures::torus(4, 1.5, 40, 16);
  const auto to = mapped(solid, [](const Point3& p) -> Point3 {
    const double angle = 2 * p.x();
    return {-p.x(), std::cos(angle) * p.y() - p.z(), std::sin(angle) * p.z() + p.y()};
  });
  const auto found = [&](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    return sweptStep(solid, to);
  };
  const SweepReport one = found(1);
  ASSERT_EQ(one.crossings.size(), 1U);
  for (const std::size_t threads : {2, 5}) {
    const SweepReport other = found(threads);
    EXPECT_EQ(other.crossingPairs, one.crossingPairs);
    ASSERT_EQ(other.crossings.size(), 1U);
    EXPECT_EQ(other.crossings[0].at, one.crossings[0].at);
    EXPECT_EQ(other.crossings[0].triangles, one.crossings[0].triangles);
    EXPECT_EQ(other.crossings[0].place, one.crossings[0].place);
  }
}

TEST(StepCrossings, BoxThatPassesThroughAnotherMeetsIt) {
  // Their nearest sides are 6 apart; the one moves by 40, through the other, and is clear of it.
  const TriangleMesh solid = fixtures::twoBoxes(2, 6);
  const auto to = mapped(solid, [](const Point3& p) -> Point3 {
    return p.x() < 0 ? Point3(p + Point3(40, 0.3, 0.4)) : p;
  });
  ASSERT_FALSE(crossesAt(solid, to, 0) || crossesAt(solid, to, 1));
  const SweepReport report = sweptStep(solid, to);
  EXPECT_GT(report.crossingPairs, 8U);
  EXPECT_EQ(report.crossingSteps, 1U);
  ASSERT_EQ(report.crossings.size(), 1U);
  const StepCrossing& first = report.crossings[0];
  EXPECT_GE(first.at, 6 / 40.0);
  EXPECT_LE(first.at, 10 / 40.0);
  EXPECT_TRUE(crossesAt(solid, to, first.at));
  expectInBoth(first, solid, to);
  ASSERT_EQ(report.notices.size(), 2U);
  EXPECT_NE(report.notices[1].find("pairs of triangles in 1 of 1 steps meet"), std::string::npos)
      << report.notices[1];
}

TEST(StepCrossings, FlapThatSwingsThroughItsBodyMeetsIt) {
  const TriangleMesh solid = plateWithFlap(3, 3);
  ASSERT_GT(signedVolume(solid), 0);
  const auto to = plateWithFlap(-4, 3).vertices;
  for (const auto& places : {solid.vertices, to}) {
    const auto checked = checkNoSelfIntersection({places, solid.triangles, {}});
    ASSERT_TRUE(checked) << checked.error().text();
  }
  const SweepReport report = sweptStep(solid, to);
  ASSERT_EQ(report.crossings.size(), 1U);
  EXPECT_TRUE(crossesAt(solid, to, report.crossings[0].at));
  // It may move freely above.
  for (const double height : {1.5, 6.0}) {
    for (const double end : {2.0, 7.0}) {
      EXPECT_EQ(sweptStep(solid, plateWithFlap(height, end).vertices).crossingPairs, 0U);
    }
  }
}

TEST(StepCrossings, ApexThatPassesThroughItsBaseSwingsItsSidesThroughIt) {
  TriangleMesh solid;
  solid.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 1}};
  solid.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  auto to = solid.vertices;
  to[3].z() = -1;
  const SweepReport report = sweptStep(solid, to);
  EXPECT_EQ(report.crossingPairs, 3U);
  EXPECT_NEAR(report.crossings.at(0).at, 0.5, 1e-6);
  EXPECT_EQ(report.crossings[0].triangles[0], 0U);
  expectInBoth(report.crossings[0], solid, to);
}

TEST(StepCrossings, AnApexThatPassesThroughAPlateMeetsItWhereItDoes) {
  // Lines along the other edges of the tetrahedron pass through the plate beside it.
  TriangleMesh solid = fixtures::cube(1);
  for (Point3& p : solid.vertices) p = p.cwiseProduct(Point3(20, 20, 1));
  const auto first = static_cast<std::uint32_t>(solid.vertices.size());
  for (const Point3& p :
       {Point3(3, 1, 0.6), Point3(2, 0.5, 2.6), Point3(4, 0.7, 2), Point3(3.1, 2.2, 3.1)}) {
    solid.vertices.push_back(p);
  }
  for (const auto& [a, b, c] : {Triangle{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    solid.triangles.push_back({first + a, first + b, first + c});
  }
  auto to = solid.vertices;
  for (std::size_t i = first; i < to.size(); ++i) to[i].z() -= 0.8;
  const SweepReport report = sweptStep(solid, to);
  ASSERT_EQ(report.crossings.size(), 1U);
  EXPECT_TRUE(crossesAt(solid, to, report.crossings[0].at));
  expectInBoth(report.crossings[0], solid, to);
}

TEST(StepCrossings, ATriangleWithoutAreaMeetsNone) {
  // A needle through the side of a cube, which is nothing but a line.
  TriangleMesh solid = fixtures::cube(2);
  const auto first = static_cast<std::uint32_t>(solid.vertices.size());
  for (const double at : {0.0, 1.0, 2.0}) solid.vertices.emplace_back(at * Point3(1, 0.25, 0.125));
  solid.triangles.push_back({first, first + 1, first + 2});
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  model::Slab step;
  step.timeEnd = 1;
  for (const double time : {0.0, 1.0}) {
    for (const Point3& p : solid.vertices) {
      step.vertices.push_back((model::Point4() << (1 + time) * p, time).finished());
    }
  }
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 2 * count;
  connectivity->lowerCount = connectivity->upperCount = count;
  step.connectivity = connectivity;
  const auto found = crossingOf(solid, step);
  ASSERT_TRUE(found);
  EXPECT_FALSE(*found);
  // With an area, it meets the side.
  solid.vertices.back().y() += 0.25;
  for (const std::uint32_t at : {count - 1, 2 * count - 1}) {
    step.vertices[at].y() = (1 + step.vertices[at].w()) * solid.vertices.back().y();
  }
  const auto wide = crossingOf(solid, step);
  ASSERT_TRUE(wide);
  EXPECT_TRUE(*wide);
}

TEST(StepCrossings, TrianglesWithACommonCornerMeetBelowIt) {
  // All other corners of the one are above those of the other, and the common one above all.
  TriangleMesh solid;
  solid.vertices = {{0, 0, 10}, {-1, 0, 1}, {1, 0, 1}, {0, -1, 0}, {0, 1, 0}};
  solid.triangles = {{0, 1, 2}, {0, 3, 4}};
  const auto found = [&] {
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 10;
    connectivity->lowerCount = connectivity->upperCount = 5;
    model::Slab step;
    step.timeEnd = 1;
    step.connectivity = connectivity;
    for (const double time : {0.0, 1.0}) {
      for (const Point3& p : solid.vertices) {
        step.vertices.push_back((model::Point4() << (1 + time) * p, time).finished());
      }
    }
    const auto crossing = crossingOf(solid, step);
    return crossing && crossing->has_value();
  };
  EXPECT_TRUE(found());
  for (const std::size_t i : {3U, 4U}) solid.vertices[i].x() += 3;
  EXPECT_FALSE(found());
}

TEST(StepCrossings, AreThoseThatSamplesShow) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  int crossing = 0;
  constexpr int kTries = 60;
  for (int i = 0; i < kTries; ++i) {
    SCOPED_TRACE(i);
    const TriangleMesh solid = fixtures::torus(2, 0.7, 9, 5);
    const double amount = 1.5 * i / kTries;
    const auto to = mapped(solid, [&](const Point3& p) -> Point3 {
      return p + amount * Point3(number(random), number(random), number(random));
    });
    const SweepReport report = sweptStep(solid, to);
    bool sampled = false;
    for (double s = 1 / 64.0; s < 1; s += 1 / 64.0) sampled |= crossesAt(solid, to, s);
    if (sampled) {
      EXPECT_GT(report.crossingPairs, 0U);
    }
    if (report.crossingPairs == 0) continue;
    ++crossing;
    // Just before, two with a common side need not have met; just after, their neighbours do.
    const double at = report.crossings[0].at;
    EXPECT_TRUE(crossesAt(solid, to, at) || crossesAt(solid, to, at + 1e-6)) << at;
    EXPECT_TRUE(report.crossings[0].place.allFinite());
    if (crossesAt(solid, to, at)) expectInBoth(report.crossings[0], solid, to);
  }
  EXPECT_GT(crossing, 10);
  EXPECT_LT(crossing, 50);
}

}  // namespace
}  // namespace t4d::mesh4d
