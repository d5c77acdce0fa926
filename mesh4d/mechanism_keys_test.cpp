#include "mesh4d/mechanism_keys.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {
namespace {

using model::Link;
using model::Point3;

model::Motion moved(const model::Joint& joint, std::vector<double> times,
                    std::vector<double> values) {
  return *model::jointMotion(joint, times, values);
}

/// A turning base, an arm on it, a slide, and a screw at its end, with times of their own.
model::Mechanism robot() {
  using Type = model::Joint::Type;
  model::Mechanism mechanism;
  mechanism.links = {
      {"base", Link::kWorld, moved({Type::Revolute, {0, 0, 0}, {0, 0, 1}}, {0, 2}, {0, 170})},
      {"arm", 0, moved({Type::Revolute, {0, 0, 5}, {0, 1, 0}}, {0, 0.7, 2}, {0, 80, -40})},
      {"slide", 1, moved({Type::Prismatic, {0, 0, 0}, {1, 0, 0}}, {0.5, 1.5}, {0, 6})},
      {"screw", 2,
       moved({Type::Screw, {12, 0, 5}, Eigen::Vector3d(1, 2, 2) / 3, 1.5}, {0, 1.1}, {0, 500})},
      {"wall", Link::kWorld, {}}};
  return mechanism;
}

TEST(MechanismKeys, ThePoseIsTheProductOfTheJoints) {
  const model::Mechanism mechanism = robot();
  using Eigen::AngleAxisd;
  using Eigen::Translation3d;
  using Eigen::Vector3d;
  const double t = 1;
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const Vector3d axis = Vector3d(1, 2, 2) / 3;
  const double screw = 500 * t / 1.1;
  const Eigen::Affine3d expected =
      AngleAxisd(radians(85), Vector3d::UnitZ()) * Translation3d(0, 0, 5) *
      AngleAxisd(radians(80 - 120 * 0.3 / 1.3), Vector3d::UnitY()) * Translation3d(0, 0, -5) *
      Translation3d(3, 0, 0) * Translation3d(12, 0, 5) * AngleAxisd(radians(screw), axis) *
      Translation3d(screw / 360 * 1.5 * axis) * Translation3d(-12, 0, -5);
  EXPECT_LE((mechanism.at(3, t).matrix() - expected.matrix().topRows<3>()).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_EQ(mechanism.knots(3), (std::vector<double>{0, 0.5, 0.7, 1.1, 1.5, 2}));
  EXPECT_EQ(mechanism.at(3, 2).matrix(), mechanism.at(3, 7).matrix());
  EXPECT_FALSE(mechanism.moves(4));
}

/// Checks that no vertex is farther from its chord than the bound says, at many times.
TEST(MechanismKeys, NoPathLeavesItsChordByMoreThanTheBound) {
  const model::Mechanism mechanism = robot();
  const model::TriangleMesh mesh = fixtures::translated(fixtures::icosphere(2, 1), {9, 1, 4});
  for (const StepRule& rule : {StepRule(MaxDeviation{0.1}), StepRule(MaxDeviation{2}),
                               StepRule(MinVolumeRatio{0.99}), StepRule(StepsPerSegment{5})}) {
    std::vector<LinkSolid> solids;
    for (std::size_t link = 0; link < mechanism.links.size(); ++link) {
      solids.push_back({&mesh, link});
    }
    const auto all = mechanismKeys(mechanism, solids, rule, PrismSplit::Fourteen, true);
    ASSERT_TRUE(all) << all.error().text();
    for (std::size_t link = 0; link < solids.size(); ++link) {
      const auto& [keys, bound] = (*all)[link];
      if (const auto* deviation = std::get_if<MaxDeviation>(&rule)) {
        EXPECT_LE(bound, deviation->length);
      }
      double worst = 0;
      for (std::uint64_t k = 0; k + 1 < keys->count(); ++k) {
        const model::Affine3x4 from = *keys->pose(k);
        const model::Affine3x4 to = *keys->pose(k + 1);
        const Eigen::Matrix3d turn = to.leftCols<3>() * from.leftCols<3>().transpose();
        const double degrees = std::abs(Eigen::AngleAxisd(turn).angle()) * 180 / std::numbers::pi;
        if (const auto* volume = std::get_if<MinVolumeRatio>(&rule)) {
          EXPECT_LE(degrees, std::acos(2 * volume->ratio - 1) * 180 / std::numbers::pi + 1e-6);
        }
        EXPECT_LE(degrees, 180);
        for (const double f : {0.25, 0.5, 0.75}) {
          const double t = keys->time(k) + f * (keys->time(k + 1) - keys->time(k));
          const model::Pose truth = mechanism.at(link, t);
          for (const Point3& vertex : mesh.vertices) {
            const Point3 chord =
                (1 - f) * model::posed(from, vertex) + f * model::posed(to, vertex);
            worst = std::max(worst, (chord - truth(vertex)).norm());
          }
        }
      }
      EXPECT_LE(worst, bound);
      // The bound is not absurdly large where there is something to bound.
      if (link < 4) {
        EXPECT_GE(worst, bound / 30);
      }
    }
  }
}

TEST(MechanismKeys, OneJointIsBoundedAsASweepIs) {
  const model::Joint joint{model::Joint::Type::Revolute, {0, 0, 0}, {0, 0, 1}};
  model::Mechanism mechanism;
  mechanism.links = {{"cube", Link::kWorld, moved(joint, {0, 1}, {0, 90})}};
  const model::TriangleMesh cube = fixtures::cube(2);
  const LinkSolid solid{&cube, 0};
  const SweepOptions options{.steps = StepsPerSegment{9}, .caps = CapMethod::Cone};
  model::NullSink sink;
  const auto swept = sweep(cube, *mechanism.links[0].motion, options, sink);
  ASSERT_TRUE(swept) << swept.error().text();
  const auto keys =
      mechanismKeys(mechanism, {&solid, 1}, options.steps, PrismSplit::Fourteen, true);
  ASSERT_TRUE(keys);
  EXPECT_EQ((*keys)[0].keys->count(), 10U);
  EXPECT_GE((*keys)[0].chordBound, *swept->chordBound);
  EXPECT_LE((*keys)[0].chordBound, 1.01 * *swept->chordBound);
}

TEST(MechanismKeys, StepsAreCommonOrEachItsOwn) {
  const model::Mechanism mechanism = robot();
  const model::TriangleMesh cube = fixtures::cube(2);
  const std::vector<LinkSolid> solids = {{&cube, 0}, {&cube, 3}, {&cube, 4}};
  const auto common =
      mechanismKeys(mechanism, solids, MaxDeviation{0.5}, PrismSplit::Fourteen, true);
  const auto own = mechanismKeys(mechanism, solids, MaxDeviation{0.5}, PrismSplit::Fourteen, false);
  ASSERT_TRUE(common && own);
  EXPECT_EQ((*common)[0].keys->count(), (*common)[1].keys->count());
  EXPECT_LT((*own)[0].keys->count(), (*own)[1].keys->count());
  for (const auto* all : {&*common, &*own}) {
    EXPECT_EQ((*all)[2].keys->count(), 2U);
    EXPECT_EQ((*all)[2].chordBound, 0);
    for (const LinkKeys& one : *all) {
      EXPECT_EQ(one.keys->time(0), 0);
      EXPECT_EQ(one.keys->time(one.keys->count() - 1), 2);
    }
  }
}

TEST(MechanismKeys, RefusesWhatCannotBeSwept) {
  model::Mechanism mechanism;
  mechanism.links = {{"wall", Link::kWorld, {}}};
  const model::TriangleMesh cube = fixtures::cube(2);
  const LinkSolid solid{&cube, 0};
  const auto errorOf = [&](const StepRule& rule) {
    const auto keys = mechanismKeys(mechanism, {&solid, 1}, rule, PrismSplit::Three, true);
    return keys ? std::string() : keys.error().text();
  };
  EXPECT_NE(errorOf(MinVolumeRatio{}).find("nothing moves"), std::string::npos);
  mechanism = robot();
  EXPECT_NE(errorOf(MaxDeviation{1e-12}).find("at most 1000"), std::string::npos);
  EXPECT_NE(errorOf(MaxDeviation{0}).find("must be a positive length"), std::string::npos);
  EXPECT_NE(errorOf(StepsPerSegment{2'000'000}).find("2e+06 steps or more"), std::string::npos);
}

TEST(MechanismKeys, StepsAreAsManyAsAreAllowed) {
  // A link far from its axis needs as many steps as the root of its distance; what is beyond is
  // refused without going through them.
  const model::Joint joint{model::Joint::Type::Revolute, {0, 0, 0}, {0, 0, 1}};
  model::Mechanism mechanism;
  mechanism.links = {{"arm", Link::kWorld, moved(joint, {0, 1}, {0, 90})}};
  for (const double distance : {1e2, 1e4, 1e8, 1e15, 1e60}) {
    const model::TriangleMesh cube =
        fixtures::translated(fixtures::cube(2), {distance, distance, 0});
    const LinkSolid solid{&cube, 0};
    const auto countWith = [&](std::optional<std::uint64_t> most) -> std::uint64_t {
      const auto keys = mechanismKeys(mechanism, {&solid, 1}, MaxDeviation{0.01},
                                      PrismSplit::Fourteen, true, most);
      return keys ? (*keys)[0].keys->count() - 1 : 0;
    };
    const std::uint64_t count = countWith(std::nullopt);
    // r (1 - cos(angle / 2)) of the farthest corner, and what edges add.
    const double least = std::numbers::pi / 4 * std::sqrt(std::sqrt(2) * distance / 0.02);
    if (least > kMostMechanismSteps) {
      EXPECT_EQ(count, 0U) << distance;
      continue;
    }
    EXPECT_GE(double(count), least) << distance;
    EXPECT_EQ(countWith(count), count);
    EXPECT_EQ(countWith(count - 1), 0U);
  }
}

}  // namespace
}  // namespace t4d::mesh4d
