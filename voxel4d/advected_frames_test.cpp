#include "voxel4d/advected_frames.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/splash.h"
#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::voxel4d {
namespace {

using Eigen::Vector3d;
using model::Point3;
using Velocity = std::function<Vector3d(const Point3& point, double time)>;

/// A moving solid, and how it moves. It lasts from time 0 to 1.
struct MovingField {
  FieldFunction distance;
  Velocity velocity;
};

/// Velocities from a function, known where the field of distances is below `reach`.
class KnownVelocities : public VelocitySource {
 public:
  KnownVelocities(MovingField field, Lattice lattice, std::vector<double> times, double reach)
      : field_(std::move(field)), lattice_(lattice), times_(std::move(times)), reach_(reach) {}

  Place placeOf(std::size_t index) const override {
    return placeIn({}, "velocity " + std::to_string(index));
  }
  Result<VelocityField> field(std::size_t index) override {
    return VelocityField{
        [this, time = times_[index]](const Coord& point) {
          const Point3 at = lattice_({double(point.x), double(point.y), double(point.z)});
          std::optional<Vector3d> known;
          if (field_.distance(at, time) < reach_) {
            known = field_.velocity(at, time) / lattice_.voxelSize;
          }
          return known;
        },
        true};
  }

 private:
  MovingField field_;
  Lattice lattice_;
  std::vector<double> times_;
  double reach_;
};

double boxDistance(const Point3& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

MovingField moved(std::function<double(const Point3&)> shape, double way) {
  return {[=](const Point3& p, double time) {
            return shape(p - Point3(way * (time - 0.5) + 0.2, 0.1, 0));
          },
          [=](const Point3&, double) { return Vector3d(way, 0, 0); }};
}
MovingField ball(double way) {
  return moved([](const Point3& p) { return p.norm() - 8; }, way);
}
MovingField plate(double way) {
  return moved([](const Point3& p) { return boxDistance(p, {1.5, 8.2, 8.2}); }, way);
}
/// It turns so that its ends move by `way`.
MovingField bar(double way) {
  const double angle = way / 12.3;
  return {
      [=](const Point3& p, double time) {
        const double c = std::cos(angle * time);
        const double s = std::sin(angle * time);
        return boxDistance({c * p.x() + s * p.y(), c * p.y() - s * p.x(), p.z()}, {12.3, 2.3, 2.3});
      },
      [=](const Point3& p, double) { return Vector3d(-angle * p.y(), angle * p.x(), 0); }};
}

model::Bounds3 boxOf(double half) {
  model::Bounds3 box;
  box.add(Point3::Constant(-half));
  box.add(Point3::Constant(half));
  return box;
}

std::unique_ptr<FrameSource> framesOf(const MovingField& field, std::vector<double> times,
                                      const SampleOptions& how = {.asFloat = true}) {
  return sampledFrames(field.distance, {}, boxOf(25), std::move(times), how);
}

std::unique_ptr<FrameSource> carried(const MovingField& field, const std::vector<double>& times,
                                     std::uint32_t substeps, double reach = 1) {
  return advectedFrames(framesOf(field, times),
                        std::make_unique<KnownVelocities>(field, Lattice{}, times, reach),
                        substeps);
}

model::Mesh woven(FrameSource& frames) {
  model::Mesh mesh;
  const auto done = weave(frames, {}, mesh);
  EXPECT_TRUE(done) << done.error().text();
  return mesh;
}

struct Measured {
  double volume = 0;  // as part of the true one
  double centroid = 0;
  double hausdorff = 0;
};

std::string textOf(const Measured& found) {
  if (found.volume == 0) return "| nothing left ";
  return fmt::format("| {:.3f}, {:.2f}, {:.2f} ", found.volume, found.centroid, found.hausdorff);
}

Measured measured(const model::Mesh& mesh, const MovingField& field, double time) {
  const auto exact =
      framesOf({[=](const Point3& p, double) { return field.distance(p, time); }, {}}, {0, 1}, {});
  const model::TriangleMesh truth = slice::sliceAtTime(woven(*exact), 0.5)->mesh;
  const model::TriangleMesh found = slice::sliceAtTime(mesh, time)->mesh;
  if (found.triangles.empty()) return {};
  const auto a = measure::measuresOf(found);
  const auto b = measure::measuresOf(truth);
  return {a.volume / b.volume, (a.centroid - b.centroid).norm(),
          measure::surfaceDistance(found, truth).hausdorff()};
}

/// Prints the table of docs/weave.md: without and with velocities, a quarter of the way and
/// halfway.
TEST(AdvectedFrames, SolidsKeepTheirVolumeAndPlaceBetweenFrames) {
  using Solid = std::pair<const char*, MovingField (*)(double way)>;
  for (const auto& [name, solid] : {Solid("ball", ball), {"plate", plate}, {"bar", bar}}) {
    for (const double way : {1.0, 3.0, 8.0}) {
      const MovingField field = solid(way);
      const model::Mesh without = woven(*framesOf(field, {0, 1}));
      const model::Mesh with = woven(*carried(field, {0, 1}, 4));
      std::string row = fmt::format("| {} | {} ", name, way);
      for (const double time : {0.25, 0.5}) {
        const Measured found = measured(with, field, time);
        row += textOf(measured(without, field, time)) + textOf(found);
        EXPECT_NEAR(found.volume, 1, 0.02) << name << way;
        EXPECT_LT(found.centroid, 0.1) << name << way;
        EXPECT_LT(found.hausdorff, 0.5) << name << way;
      }
      fmt::print("{}|\n", row);
    }
  }
}

/// A fog: 1 inside, 0 outside, and a ramp of two voxels in between.
TEST(AdvectedFrames, DensitiesAreCarriedAsDistances) {
  const MovingField field = plate(8);
  const MovingField fog = {[=](const Point3& p, double time) {
                             return std::clamp(field.distance(p, time) / 2, -0.5, 0.5);
                           },
                           field.velocity};
  const auto frames = advectedFrames(
      framesOf(fog, {0, 1}, {.band = 0.5, .asFloat = true}),
      std::make_unique<KnownVelocities>(field, Lattice{}, std::vector<double>{0, 1}, 1.0), 4);
  const Measured half = measured(woven(*frames), field, 0.5);
  EXPECT_NEAR(half.volume, 1, 0.03);
  EXPECT_LT(half.centroid, 0.1);
}

/// Where two drops merge, and where their splash parts, the volume between two frames is within 2 %
/// of theirs.
TEST(AdvectedFrames, ASplashGoesOnBetweenFrames) {
  constexpr double kFrameTime = 0.05;
  const auto splash = fixtures::Splash::frames(22, kFrameTime);
  const auto at = [&](double time) -> const fixtures::Splash& {
    return splash[static_cast<std::size_t>(std::lround(time / kFrameTime))];
  };
  const MovingField field = {[&](const Point3& p, double time) { return at(time).distance(p); },
                             [&](const Point3& p, double time) { return at(time).velocity(p); }};
  for (const std::size_t first : {0, 18}) {
    const std::vector<double> times = {splash[first].time, splash[first + 1].time,
                                       splash[first + 2].time};
    const model::Mesh mesh = woven(*carried(field, times, 4));
    std::vector<double> volumes;
    for (std::uint64_t i = 0; i <= 8; ++i) {
      const double time = model::dividedTime({times.front(), times.back()}, i, 8);
      volumes.push_back(measure::measuresOf(slice::sliceAtTime(mesh, time)->mesh).volume);
    }
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t frame = i / 4 * 4;
      const auto [low, high] = std::minmax(volumes[frame], volumes[frame + 4]);
      EXPECT_GT(volumes[i], 0.98 * low) << first << " " << i;
      EXPECT_LT(volumes[i], 1.02 * high) << first << " " << i;
    }
  }
}

TEST(AdvectedFrames, AreTheSameForAnyNumberOfThreads) {
  const auto valuesWith = [](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    const auto frames = carried(bar(3), {0, 1}, 2);
    EXPECT_TRUE(frames->frame(0));
    const auto frame = frames->frame(1);
    std::vector<double> values;
    for (const Block& block : frame->blocks) {
      for (unsigned i = 0; i < 512; ++i) values.push_back(block.values.at(i));
    }
    return values;
  };
  EXPECT_EQ(valuesWith(1), valuesWith(4));
}

TEST(AdvectedFrames, MasksAreRefused) {
  const MovingField field = ball(1);
  const auto frames = advectedFrames(
      framesOf(field, {0, 1}, {.mask = true}),
      std::make_unique<KnownVelocities>(field, Lattice{}, std::vector<double>{0, 1}, 1.0), 2);
  const auto frame = frames->frame(0);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().where.text(), "frame 0");
}

}  // namespace
}  // namespace t4d::voxel4d
