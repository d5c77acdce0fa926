#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// The table of volumes between frames in docs/weave.md, and what holds of it.
namespace t4d::voxel4d {
namespace {

using model::Point3;

/// A solid of which some point moves by a voxel in a time of 1.
struct Moving {
  std::string name;
  FieldFunction field;
  std::function<double(double time)> volume;
  std::function<Point3(double time)> centroid;
};

double boxDistance(const Point3& point, const Point3& half) {
  const Point3 beyond = point.cwiseAbs() - half;
  return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

/// The balls are off the lattice, so that no symmetry helps. Boxes begin between lattice points.
const Point3 kCentre(0.3, -0.3, 0.1);
constexpr double kRadius = 15;

std::vector<Moving> solids() {
  const auto ball = [](double radius) { return 4 * std::numbers::pi / 3 * std::pow(radius, 3); };
  const Point3 along = Point3(1, 2, 3).normalized();
  const Point3 bar(20.5, 5.5, 5.5);
  const Point3 plate(1.5, 12.5, 12.5);
  return {
      {"ball of radius 15 that grows",
       [](const Point3& p, double time) { return (p - kCentre).norm() - kRadius - time; },
       [=](double time) { return ball(kRadius + time); }, [](double) { return kCentre; }},
      {"ball of radius 15 that moves",
       [=](const Point3& p, double time) { return (p - kCentre - time * along).norm() - kRadius; },
       [=](double) { return ball(kRadius); },
       [=](double time) -> Point3 { return kCentre + time * along; }},
      {"plate 3 thick that moves across",
       [=](const Point3& p, double time) { return boxDistance(p - Point3(time, 0, 0), plate); },
       [=](double) { return 8 * plate.prod(); }, [](double time) { return Point3(time, 0, 0); }},
      {"bar of 41 x 11 x 11 that turns",
       [=](const Point3& p, double time) {
         const Eigen::AngleAxisd back(-time / bar.x(), Point3::UnitZ());
         return boxDistance(back * p, bar);
       },
       [=](double) { return 8 * bar.prod(); }, [](double) -> Point3 { return Point3::Zero(); }},
  };
}

enum class Way : std::uint8_t { LevelSet, Distance, Midpoint };

struct Errors {
  double volume = 0;       // relative
  double place = 0;        // of the centroid, in voxels
  std::uint64_t lost = 0;  // parts, as weave says
};

/// The worst errors a quarter, nearly half, just over half, and three quarters of the way between
/// frames, in which the solid moves by `step` voxels.
Errors worstErrors(const Moving& solid, double step, Way way) {
  const double reach = 24 + 2 * step;
  auto frames = sampledFrames(solid.field, {}, {Point3::Constant(-reach), Point3::Constant(reach)},
                              {0, step, 2 * step}, {.slope = 1, .mask = way != Way::LevelSet});
  model::Mesh mesh;
  const auto between = way == Way::Midpoint ? Between::Midpoint : Between::Distance;
  const auto report = weave(*frames, {.between = between}, mesh);
  EXPECT_TRUE(report);
  std::vector<double> times;
  for (const double frame : {0, 1}) {
    for (const double part : {0.25, 0.499, 0.501, 0.75}) times.push_back(step * (frame + part));
  }
  Errors worst;
  if (report) worst.lost = report->partsLost.count;
  const auto slices = slice::sliceAtTimes(mesh, times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_TRUE(slices[i]);
    const auto found = measure::measuresOf(slices[i]->mesh);
    const double error = found.volume / solid.volume(times[i]) - 1;
    if (std::abs(error) > std::abs(worst.volume)) worst.volume = error;
    if (found.volume == 0) continue;
    worst.place = std::max(worst.place, (found.centroid - solid.centroid(times[i])).norm());
  }
  return worst;
}

std::string textOf(const Errors& errors) {
  if (errors.volume == -1) return "gone";
  return fmt::format("{:+.1f} %, {:.2f}", 100 * errors.volume, errors.place);
}

TEST(BetweenFrames, VolumesAreTheTableOfThePage) {
  std::cout << "| solid | voxels a frame | level sets | `distance` | `midpoint` |\n"
               "|---|--:|--:|--:|--:|\n";
  for (const Moving& solid : solids()) {
    for (const double step : {1, 2, 3, 4, 6, 8}) {
      SCOPED_TRACE(fmt::format("{} {}", solid.name, step));
      const Errors levelSet = worstErrors(solid, step, Way::LevelSet);
      const Errors distance = worstErrors(solid, step, Way::Distance);
      const Errors midpoint = worstErrors(solid, step, Way::Midpoint);
      std::cout << fmt::format("| {} | {} | {} | {} | {} |\n", solid.name, step, textOf(levelSet),
                               textOf(distance), textOf(midpoint));
      const bool grows = solid.name.ends_with("grows");
      const bool isThin = solid.name.starts_with("plate");
      // Distances do what level sets do, within what voxels do to the volume of the frames.
      EXPECT_NEAR(distance.volume, levelSet.volume, grows ? 0.04 : 0.015);
      EXPECT_NEAR(distance.place, levelSet.place, 0.2);
      if (grows) {
        EXPECT_LT(std::abs(distance.volume), 0.03);
        EXPECT_GT(std::abs(midpoint.volume), step > 1 ? 0.055 * step : 0);
      }
      // Without distances, solids stay where they are up to the middle.
      if (solid.name.ends_with("moves") && step > 1) {
        EXPECT_LT(distance.place, 0.15);
        EXPECT_GT(midpoint.place, step / 2 - 0.85);
      }
      // Parts that are gone are reported.
      EXPECT_EQ(distance.lost > 0, isThin && step >= 3);
      EXPECT_EQ(distance.volume == -1, isThin && step >= 4);
    }
  }
}

}  // namespace
}  // namespace t4d::voxel4d
