#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "measure/triangle_tree.h"
#include "mesh4d/steps.h"
#include "t4d/check.h"
#include "t4d/motion.h"
#include "t4d/slice.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"
#include "tests/paths.h"

/// Theorems for every swept solid, whatever the mesh and the motion: the slice volumes of
/// DESIGN.md, exact layers, closed sections by any hyperplane.
namespace t4d::slice {
namespace {

constexpr double kRelative = 1e-9;

struct Solid {
  std::string name;
  model::TriangleMesh mesh;
  mesh4d::CapMethod caps = mesh4d::CapMethod::TetGen;
};

/// The fixtures, and the real meshes if they are present.
const std::vector<Solid>& solids() {
  static const std::vector<Solid> all = [] {
    std::vector<Solid> list;
    for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
      list.push_back({solid.name, solid.mesh});
    }
    const std::filesystem::path folder = T4D_SHARED_MESHES;
    if (!std::filesystem::exists(folder)) {
      std::cout << "real meshes are left out: no folder " << folder << "\n";
      return list;
    }
    for (const char* name : {"spot_low_resolution", "fish_low_resolution", "goathead", "wingnut"}) {
      auto loaded = formats::readTriangleMesh(folder / (std::string(name) + ".obj"));
      EXPECT_TRUE(loaded) << loaded.error().text();
      const bool intersects = std::string(name) == "wingnut";
      list.push_back(
          {name, loaded->mesh, intersects ? mesh4d::CapMethod::Cone : mesh4d::CapMethod::TetGen});
    }
    return list;
  }();
  return all;
}

std::vector<std::pair<std::string, model::Motion>> motions() {
  std::vector<std::pair<std::string, model::Motion>> list;
  for (const fixtures::NamedMotion& motion : fixtures::allMotions()) {
    auto parsed = formats::parseMotion(motion.json, motion.name);
    EXPECT_TRUE(parsed) << parsed.error().text();
    list.emplace_back(motion.name, *parsed);
  }
  return list;
}

/// A sweep, and the rotation angle of each of its steps.
struct Swept {
  model::Mesh mesh;
  mesh4d::SweepReport report;
  std::vector<double> angle;  // radians, of slab i + 1
};

Swept sweepOf(const Solid& solid, const model::Motion& motion, const mesh4d::StepRule& rule,
              mesh4d::PrismSplit prism = mesh4d::PrismSplit::Fourteen) {
  Swept swept;
  auto report = mesh4d::sweep(solid.mesh, motion, {rule, solid.caps, prism}, swept.mesh);
  EXPECT_TRUE(report) << solid.name << ": " << report.error().text();
  if (!report) return swept;
  swept.report = *report;
  const auto counts = *mesh4d::stepsOf(motion, rule, mesh4d::chordsOf(motion, solid.mesh, prism));
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double degrees = motion.segments[i].screw.angleDegrees;
    for (std::uint64_t k = 0; k < counts[i]; ++k) {
      swept.angle.push_back(degrees / static_cast<double>(counts[i]) * std::numbers::pi / 180);
    }
  }
  return swept;
}

/// V0 (1 - 2 s (1 - s) (1 - cos theta)) at fraction s of a step.
double sliceVolume(double volume, double s, double theta) {
  return volume * (1 - 2 * s * (1 - s) * (1 - std::cos(theta)));
}

TEST(Swept, PaperCubeHasThePapersCounts) {
  Solid cube{"paper-cube", fixtures::paperCube(20)};
  model::Screw up;
  up.translation = {0, 0, 1};
  const model::ScrewRun run{1, up, 64};
  Swept swept = sweepOf(cube, *model::chainScrews(0, std::span(&run, 1)), {});
  EXPECT_EQ(swept.report.vertices, 4750U);
  EXPECT_EQ(swept.report.tetrahedra, 21552U);
  EXPECT_EQ(swept.report.capTetrahedra, (std::array<std::uint64_t, 2>{24, 24}));
  const auto report = *measure::checkMesh(swept.mesh, {.vertexLinks = true});
  EXPECT_TRUE(report.valid() && *report.vertexLinksOk);
  EXPECT_EQ(report.vertices, 4750U);
  EXPECT_EQ(report.tetrahedra, 21552U);
  EXPECT_NEAR(report.hypervolume, 512000, 512000 * kRelative);
}

TEST(Swept, EverySolidAndMotionIsClosedOrientedAndObeysTheLaw) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> fraction(0.01, 0.99);
  for (const Solid& solid : solids()) {
    const double volume = signedVolume(solid.mesh);
    const auto v = solid.mesh.vertices.size();
    const auto f = solid.mesh.triangles.size();
    for (const auto& [name, motion] : motions()) {
      SCOPED_TRACE(solid.name + " along " + name);
      Swept swept = sweepOf(solid, motion, mesh4d::MinVolumeRatio{0.98});
      ASSERT_FALSE(swept.mesh.slabs().empty());
      const std::size_t steps = swept.angle.size();
      ASSERT_EQ(swept.report.steps, steps);

      const auto report = *measure::checkMesh(swept.mesh, {.vertexLinks = true});
      ASSERT_TRUE(report.closed && report.oriented) << report.issues.issues.front().message;
      EXPECT_EQ(report.issues.errors, 0U);
      EXPECT_EQ(report.vertices, swept.report.vertices);
      EXPECT_EQ(report.tetrahedra, swept.report.tetrahedra);
      EXPECT_EQ(report.tetrahedra,
                14 * f * steps + swept.report.capTetrahedra[0] + swept.report.capTetrahedra[1]);
      // E = 3 F / 2; the caps may have points inside.
      EXPECT_GE(report.vertices, (steps + 1) * v + steps * (3 * f / 2 + f));

      double expected = 0;
      for (std::size_t i = 0; i < steps; ++i) {
        const model::TimeSpan span = swept.mesh.timeSpan(i + 1);
        expected += volume * (span.end - span.begin) * (2 + std::cos(swept.angle[i])) / 3;
      }
      EXPECT_NEAR(report.hypervolume, expected, expected * kRelative);

      for (std::size_t i = 0; i < steps; i += 1 + steps / 5) {
        const model::TimeSpan span = swept.mesh.timeSpan(i + 1);
        for (const double s : {0.0, 0.5, fraction(random), fraction(random)}) {
          const auto slice = sliceAtTime(swept.mesh, span.begin + s * (span.end - span.begin));
          ASSERT_TRUE(slice);
          EXPECT_TRUE(isClosed(slice->mesh));
          EXPECT_NEAR(signedVolume(slice->mesh), sliceVolume(volume, s, swept.angle[i]),
                      volume * kRelative);
        }
      }
    }
  }
}

TEST(Swept, SliceAtALayerIsThePosedInput) {
  for (const Solid& solid : solids()) {
    for (const auto& [name, motion] : motions()) {
      SCOPED_TRACE(solid.name + " along " + name);
      Swept swept = sweepOf(solid, motion, mesh4d::MinVolumeRatio{0.9});
      const std::size_t slabs = swept.mesh.slabCount();
      for (const std::size_t i : {std::size_t{1}, slabs / 2, slabs - 2, slabs - 1}) {
        const double time = swept.mesh.timeSpan(i).begin;
        const auto slice = sliceAtTime(swept.mesh, time);
        ASSERT_TRUE(slice);
        // Equal vertices in the same order, and the same triangles.
        const auto layer = swept.mesh.slabs()[i].lowerLayer();
        ASSERT_EQ(slice->mesh.vertices.size(), solid.mesh.vertices.size());
        for (std::size_t k = 0; k < layer.size(); ++k) {
          ASSERT_EQ(slice->mesh.vertices[k], model::Point3(layer[k].head<3>()));
        }
        const auto canonical = [](std::vector<model::Triangle> triangles) {
          for (model::Triangle& t : triangles) {
            std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
          }
          std::sort(triangles.begin(), triangles.end());
          return triangles;
        };
        EXPECT_EQ(canonical(slice->mesh.triangles), canonical(solid.mesh.triangles));
      }
    }
  }
}

TEST(Swept, SectionByAnyHyperplaneIsClosedAndFacesOutward) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const Solid& solid : solids()) {
    if (solid.mesh.triangles.size() > 2000) continue;
    for (const auto& [name, motion] : motions()) {
      SCOPED_TRACE(solid.name + " along " + name);
      Swept swept = sweepOf(solid, motion, mesh4d::MinVolumeRatio{0.9});
      const auto report = *measure::checkMesh(swept.mesh);
      const model::Point4 middle = 0.5 * (report.bounds.min + report.bounds.max);
      for (int i = 0; i < 8; ++i) {
        // The three axes, then arbitrary directions.
        Hyperplane hyperplane;
        hyperplane.normal =
            i < 3 ? Eigen::Vector4d(Eigen::Vector4d::Unit(i))
                  : Eigen::Vector4d(number(random), number(random), number(random), number(random));
        hyperplane.offset = hyperplane.normal.dot(middle) + 0.01 * number(random);
        const auto section = slice(swept.mesh, hyperplane);
        ASSERT_TRUE(section);
        EXPECT_TRUE(isClosed(section->mesh));
        EXPECT_GE(signedVolume(section->mesh), -1e-9);
      }
    }
  }
}

/// The hypervolume is the integral of the section's volume over the offset, for any direction.
TEST(Swept, SectionsIntegrateToTheHypervolume) {
  const Solid solid{"torus", fixtures::torus(2, 0.7, 12, 8)};
  const auto motion = formats::parseMotion(fixtures::allMotions()[4].json, "motion");
  Swept swept = sweepOf(solid, *motion, mesh4d::MinVolumeRatio{0.99});
  const auto report = *measure::checkMesh(swept.mesh);
  for (const Eigen::Vector4d& normal :
       {Eigen::Vector4d(1, 0, 0, 0), Eigen::Vector4d(0, 0, 1, 0), Eigen::Vector4d(1, 2, -1, 1.5)}) {
    double low = 1e300;
    double high = -1e300;
    for (const model::Slab& slab : swept.mesh.slabs()) {
      for (const model::Point4& vertex : slab.vertices) {
        low = std::min(low, normal.dot(vertex));
        high = std::max(high, normal.dot(vertex));
      }
    }
    constexpr int kSections = 200;
    double sum = 0;
    for (int i = 0; i < kSections; ++i) {
      const double offset = low + (high - low) * (i + 0.5) / kSections;
      sum += signedVolume(slice(swept.mesh, {normal, offset})->mesh);
    }
    const double integral = sum * (high - low) / kSections / normal.norm();
    EXPECT_NEAR(integral, report.hypervolume, 1e-3 * report.hypervolume);
  }
}

TEST(Swept, ThreeCellSplitIsClosedAndOriented) {
  for (const Solid& solid : solids()) {
    for (const auto& [name, motion] : motions()) {
      SCOPED_TRACE(solid.name + " along " + name);
      Swept swept = sweepOf(solid, motion, mesh4d::MinVolumeRatio{0.9}, mesh4d::PrismSplit::Three);
      const auto report = *measure::checkMesh(swept.mesh);
      EXPECT_TRUE(report.closed && report.oriented);
      EXPECT_EQ(report.tetrahedra, 3 * solid.mesh.triangles.size() * swept.report.steps +
                                       swept.report.capTetrahedra[0] +
                                       swept.report.capTetrahedra[1]);
      EXPECT_TRUE(isClosed(sliceAtTime(swept.mesh, 0.37 * motion.timeEnd())->mesh));
    }
  }
}

/// The farthest that a corner or a centroid of `mesh` is from `other`.
double farthest(const model::TriangleMesh& mesh, const measure::TriangleTree& other) {
  double most = 0;
  for (const model::Point3& vertex : mesh.vertices) {
    most = std::max(most, other.nearest(vertex).distance);
  }
  for (const model::Triangle& triangle : mesh.triangles) {
    const auto& v = mesh.vertices;
    const model::Point3 centroid = (v[triangle[0]] + v[triangle[1]] + v[triangle[2]]) / 3;
    most = std::max(most, other.nearest(centroid).distance);
  }
  return most;
}

/// How far the slices of a sweep are from the moved solid, in both directions.
double deviationOf(const Solid& solid, const model::Motion& motion, const Swept& swept) {
  double worst = 0;
  for (std::size_t i = 1; i + 1 < swept.mesh.slabCount(); ++i) {
    const model::Slab& slab = swept.mesh.slabs()[i];
    for (const double s : {0.25, 0.5, 0.8}) {
      const double time = slab.timeBegin + s * (slab.timeEnd - slab.timeBegin);
      model::TriangleMesh posed = solid.mesh;
      for (model::Point3& vertex : posed.vertices) vertex = motion.at(time)(vertex);
      const auto slice = sliceAtTime(swept.mesh, time);
      EXPECT_TRUE(slice);
      if (!slice) return worst;
      worst = std::max({worst, farthest(slice->mesh, measure::TriangleTree(posed)),
                        farthest(posed, measure::TriangleTree(slice->mesh))});
    }
  }
  return worst;
}

TEST(Swept, MaxDeviationBoundsWholeSlices) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return model::Point3(unit(random), unit(random), unit(random)); };
  std::vector<Solid> all = solids();
  Solid bar{"bar", fixtures::cube(1)};
  for (model::Point3& vertex : bar.mesh.vertices) vertex.x() *= 10;
  all.insert(all.end(), 12, bar);
  for (const Solid& solid : all) {
    SCOPED_TRACE(solid.name);
    const model::Bounds3 bounds = boundsOf(solid.mesh);
    const double size = (bounds.max - bounds.min).norm();
    for (const auto split : {mesh4d::PrismSplit::Fourteen, mesh4d::PrismSplit::Three}) {
      model::ScrewRun run;
      run.duration = 1;
      run.screw.axisPoint = bounds.min + size * point();
      run.screw.axisDirection = point();
      run.screw.translation = size * point();
      run.screw.angleDegrees = 1;
      const double allowed = size * std::pow(10, 3 * unit(random) - 3.5);
      // A few steps.
      const auto one = model::chainScrews(0, {&run, 1});
      run.screw.angleDegrees = unit(random) * 600 / std::numbers::pi *
                               mesh4d::chordsOf(*one, solid.mesh, split).front().angleFor(allowed);
      const auto motion = model::chainScrews(0, {&run, 1});
      ASSERT_TRUE(motion);
      const Swept swept = sweepOf(solid, *motion, mesh4d::MaxDeviation{allowed}, split);
      ASSERT_TRUE(swept.report.chordBound);
      EXPECT_LE(*swept.report.chordBound, allowed);
      const double rounding = 1e-13 * size;
      EXPECT_LE(deviationOf(solid, *motion, swept), *swept.report.chordBound + rounding);
    }
  }
}

TEST(Swept, LongEdgesAreWithinTheDeviation) {
  // With steps of an eighth of a degree, its corners stay within 3e-6 of their paths, its slices
  // are 1e-3 off.
  Solid bar{"bar", fixtures::cube(1)};
  for (model::Point3& vertex : bar.mesh.vertices) vertex.x() *= 10;
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 1;
  const auto motion = model::chainScrews(0, {&run, 1});
  const Swept vertices = sweepOf(bar, *motion, mesh4d::StepsPerSegment{8});
  EXPECT_GT(deviationOf(bar, *motion, vertices), 1e-3 / 2);
  const Swept whole = sweepOf(bar, *motion, mesh4d::MaxDeviation{1e-4});
  EXPECT_LE(deviationOf(bar, *motion, whole), 1e-4);
  // No more steps than needed, but for what the bound is above the deviation.
  EXPECT_GT(deviationOf(bar, *motion, whole), 1e-4 / 2);
}

TEST(Swept, AttributesNameTheTriangleThatATriangleCameFrom) {
  const Solid solid{"icosphere", fixtures::icosphere(1, 1)};
  const auto motion = formats::parseMotion(fixtures::allMotions()[4].json, "motion");
  Swept swept = sweepOf(solid, *motion, {});
  const auto atLayer = *sliceAtTime(swept.mesh, 0);
  ASSERT_EQ(atLayer.mesh.attributes.size(), 2U);
  EXPECT_EQ(atLayer.mesh.attributes[0].name, "triangle");
  for (std::size_t i = 0; i < atLayer.mesh.triangles.size(); ++i) {
    std::uint32_t from = 0;
    std::memcpy(&from, atLayer.mesh.attributes[0].row(i), sizeof from);
    EXPECT_EQ(atLayer.mesh.triangles[i], solid.mesh.triangles[from]);
  }
}

}  // namespace
}  // namespace t4d::slice
