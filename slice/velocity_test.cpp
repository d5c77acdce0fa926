#include "slice/velocity.h"

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::slice {
namespace {

using mesh4d::PrismSplit;
using model::Mesh;
using model::Point3;
using model::TriangleMesh;

mesh4d::SweepOptions sweepOptions(PrismSplit prism) {
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  options.prism = prism;
  return options;
}

/// A solid in one step of length 0.7 to where `moved` puts its vertices.
Mesh sweptOnce(const TriangleMesh& solid, PrismSplit prism,
               const std::function<Point3(const Point3&)>& moved) {
  std::vector<model::StoredKeys::Key> keys = {{0, solid.vertices}, {0.7, {}}};
  for (const Point3& vertex : solid.vertices) keys[1].positions.push_back(moved(vertex));
  Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, model::StoredKeys(std::move(keys)), sweepOptions(prism), mesh));
  return mesh;
}

Mesh scattered(const TriangleMesh& solid, PrismSplit prism) {
  std::mt19937 random(7);
  std::normal_distribution<double> offset(0, 0.2);
  return sweptOnce(solid, prism, [&](const Point3& vertex) {
    return Point3(vertex + Point3(offset(random), offset(random), offset(random)));
  });
}

std::vector<Point3> velocitiesOf(const TriangleMesh& mesh) {
  const model::Attribute& attribute = mesh.attributes.back();
  EXPECT_EQ(attribute.name, kVelocity);
  EXPECT_EQ(attribute.rows(), mesh.vertices.size());
  std::vector<Point3> velocities;
  for (std::size_t row = 0; row < attribute.rows(); ++row) {
    std::array<double, 3> numbers;
    std::memcpy(numbers.data(), attribute.row(row), sizeof(numbers));
    velocities.emplace_back(numbers[0], numbers[1], numbers[2]);
  }
  return velocities;
}

Slice exactAt(const Mesh& mesh, double time) { return *TimeSlicer(mesh, WithMotion::Yes).at(time); }

Slice lightAt(const Mesh& mesh, double time) {
  return LightSlicer(mesh, WithMotion::Yes).at(time)->slice;
}

/// Exact for the volumes of slices between two layers, which are cubic in time.
double volumeRateAt(const Mesh& mesh, double time) {
  const auto difference = [&](double by) {
    return signedVolume(sliceAtTime(mesh, time + by)->mesh) -
           signedVolume(sliceAtTime(mesh, time - by)->mesh);
  };
  const double h = 0.05;
  return (8 * difference(h) - difference(2 * h)) / (12 * h);
}

const TriangleMesh solids[] = {fixtures::cube(2), fixtures::torus(3, 1, 12, 7),
                               fixtures::hollowCube(3, 1), fixtures::pebble(2, 90)};

TEST(Velocity, FluxIsTheRateOfTheVolume) {
  for (const TriangleMesh& solid : solids) {
    for (const PrismSplit prism : {PrismSplit::Fourteen, PrismSplit::Three}) {
      const Mesh mesh = scattered(solid, prism);
      for (const double time : {0.11, 0.35, 0.5}) {
        const double rate = volumeRateAt(mesh, time);
        const double tolerance = 1e-9 * (1 + std::abs(rate));
        for (Slice slice : {exactAt(mesh, time), lightAt(mesh, time)}) {
          EXPECT_NEAR(addVelocity(slice)->volumeRate, rate, tolerance);
        }
      }
    }
  }
}

TEST(Velocity, AtLayersIsTheLimitFromWithin) {
  const Mesh mesh = scattered(fixtures::torus(3, 1, 12, 7), PrismSplit::Fourteen);
  for (const auto& [layer, within] : {std::pair(0.0, 1e-7), {0.7, 0.7 - 1e-7}}) {
    for (const auto& sliceAt : {exactAt, lightAt}) {
      Slice at = sliceAt(mesh, layer);
      Slice beside = sliceAt(mesh, within);
      EXPECT_NEAR(addVelocity(at)->volumeRate, addVelocity(beside)->volumeRate, 1e-4);
    }
  }
}

TEST(Velocity, LightSlicesMoveByItOntoTheNext) {
  for (const TriangleMesh& solid : solids) {
    const Mesh mesh = scattered(solid, PrismSplit::Fourteen);
    Slice slice = lightAt(mesh, 0.2);
    EXPECT_TRUE(addVelocity(slice)->ofPoints);
    const std::vector<Point3> velocities = velocitiesOf(slice.mesh);
    const Slice later = lightAt(mesh, 0.6);
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      const Point3 moved = slice.mesh.vertices[i] + 0.4 * velocities[i];
      EXPECT_LT((moved - later.mesh.vertices[i]).norm(), 1e-12);
    }
  }
}

/// Whatever is known of the motion: the cells of Three are no prisms.
TEST(Velocity, OfATranslatedCubeIsThatOfItsCornersEdgesAndFaces) {
  const Point3 step(0.5, -1, 2);
  const auto moved = [&](const Point3& vertex) { return Point3(vertex + step); };
  for (const PrismSplit prism : {PrismSplit::Fourteen, PrismSplit::Three}) {
    const Mesh mesh = sweptOnce(fixtures::paperCube(2), prism, moved);
    for (const double time : {0.0, 0.3, 0.7}) {
      Slice slice = exactAt(mesh, time);
      const auto report = addVelocity(slice);
      EXPECT_EQ(report->ofPoints, prism == PrismSplit::Fourteen);
      const std::vector<Point3> velocities = velocitiesOf(slice.mesh);
      const model::Bounds3 bounds = boundsOf(slice.mesh);
      for (std::size_t i = 0; i < velocities.size(); ++i) {
        const Point3& at = slice.mesh.vertices[i];
        for (int k = 0; k < 3; ++k) {
          const bool onFace =
              at[k] - bounds.min[k] < 1e-9 || bounds.max[k] - at[k] < 1e-9 || report->ofPoints;
          EXPECT_NEAR(velocities[i][k], onFace ? step[k] / 0.7 : 0, 1e-9);
        }
      }
    }
  }
}

/// Half way through a step, a chord has the direction of the arc and its speed but for the cube of
/// the angle.
TEST(Velocity, OfATurnedSolidIsThatOfItsScrewToSecondOrder) {
  const auto errorOf = [](std::uint64_t steps, const auto& sliceAt) {
    model::Screw screw;
    screw.angleDegrees = 90;
    screw.translation = {0, 0, 3};
    const model::ScrewRun run{1, screw, 1};
    mesh4d::SweepOptions options = sweepOptions(PrismSplit::Fourteen);
    options.steps = mesh4d::StepsPerSegment{steps};
    Mesh mesh;
    EXPECT_TRUE(mesh4d::sweep(fixtures::torus(3, 1, 24, 12), *model::chainScrews(0, {&run, 1}),
                              options, mesh));
    Slice slice = sliceAt(mesh, 0.5 / static_cast<double>(steps));
    EXPECT_TRUE(addVelocity(slice));
    const std::vector<Point3> velocities = velocitiesOf(slice.mesh);
    double error = 0;
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      const Point3& at = slice.mesh.vertices[i];
      const double radians = std::acos(-1) / 2;
      const Point3 field(-radians * at.y(), radians * at.x(), 3);
      error = std::max(error, (velocities[i] - field).norm() / field.norm());
    }
    return error;
  };
  for (const auto& sliceAt : {exactAt, lightAt}) {
    const double coarse = errorOf(5, sliceAt);
    const double fine = errorOf(10, sliceAt);
    EXPECT_LT(fine, 0.01);
    EXPECT_NEAR(coarse / fine, 4, 0.3);
  }
}

TEST(Velocity, IsClampedInItsDirection) {
  const Mesh mesh = scattered(fixtures::torus(3, 1, 12, 7), PrismSplit::Fourteen);
  Slice slice = exactAt(mesh, 0.3);
  Slice same = exactAt(mesh, 0.3);
  const auto free = addVelocity(slice);
  const double most = free->maxSpeed / 2;
  const auto report = addVelocity(same, {.most = most});
  EXPECT_EQ(free->clamped, 0);
  EXPECT_DOUBLE_EQ(report->maxSpeed, most);
  EXPECT_DOUBLE_EQ(report->volumeRate, free->volumeRate);
  const auto before = velocitiesOf(slice.mesh);
  const auto after = velocitiesOf(same.mesh);
  std::uint64_t clamped = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    clamped += before[i].norm() > most ? 1 : 0;
    EXPECT_LE(after[i].norm(), most * (1 + 1e-12));
    EXPECT_LT(after[i].cross(before[i]).norm(), 1e-12 * before[i].squaredNorm() + 1e-300);
  }
  EXPECT_GT(clamped, 0);
  EXPECT_EQ(report->clamped, clamped);
}

TEST(Velocity, IsNotThereUnlessASlicerWasAskedForIt) {
  const Mesh mesh = scattered(fixtures::cube(2), PrismSplit::Fourteen);
  Slice slice = *sliceAtTime(mesh, 0.3);
  const std::size_t attributes = slice.mesh.attributes.size();
  EXPECT_TRUE(addVelocity(slice));
  EXPECT_EQ(slice.mesh.attributes.size(), attributes);
}

}  // namespace
}  // namespace t4d::slice
