#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "measure/mesh_digest.h"
#include "measure/surface_genus.h"
#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/motion.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::edit {
namespace {

model::Mesh wovenField(const fixtures::Field& field, std::size_t frames) {
  model::Mesh mesh;
  const auto source = voxel4d::sampledFrames(
      field.value, {}, field.box, model::evenTimes({field.timeBegin, field.timeEnd}, frames),
      {.slope = field.slope});
  EXPECT_TRUE(voxel4d::weave(*source, {}, mesh));
  return mesh;
}

model::Mesh sweptBall() {
  model::Mesh mesh;
  const auto motion = fixtures::allMotions()[1];
  EXPECT_TRUE(mesh4d::sweep(fixtures::icosphere(3, 1),
                            *formats::parseMotion(motion.json, motion.name),
                            {mesh4d::StepsPerSegment{6}, mesh4d::CapMethod::Cone}, mesh));
  return mesh;
}

std::vector<model::Mesh> simplifySamples() {
  std::vector<model::Mesh> list;
  list.push_back(sweptBall());
  list.push_back(wovenField(fixtures::translatingSphere(2, {2, 1, 1}), 4));
  list.push_back(wovenField(fixtures::mergingSpheres(2), 7));
  list.push_back(wovenField(fixtures::closingTorus(3), 5));
  return list;
}

struct SimplifiedMesh {
  model::Mesh mesh;
  SimplifyReport report;
};

SimplifiedMesh simplified(const model::Source& source, const SimplifyOptions& options) {
  SimplifiedMesh made;
  auto report = simplify(source, options, made.mesh);
  EXPECT_TRUE(report) << report.error().text();
  if (report) made.report = *report;
  return made;
}

model::TriangleMesh solidAt(const model::Source& mesh, double time) {
  const auto slice = slice::slice(mesh, slice::Hyperplane::atTime(time));
  EXPECT_TRUE(slice) << slice.error().text();
  return slice->mesh;
}

TEST(Simplify, TheResultIsTheSameManifoldWithTheSameHypervolume) {
  for (const model::Mesh& mesh : simplifySamples()) {
    const auto before = measure::checkMesh(mesh, {.vertexLinks = true});
    for (const std::uint64_t window : {1, 2, 100}) {
      const auto made = simplified(mesh, {.ratio = 0.3, .timeScale = 4, .windowSlabs = window});
      const auto after = measure::checkMesh(made.mesh, {.vertexLinks = true});
      ASSERT_TRUE(after && after->valid());
      EXPECT_EQ(after->components, before->components);
      EXPECT_NEAR(after->hypervolume, before->hypervolume, 1e-11 * before->hypervolume);
      EXPECT_EQ(after->time.begin, before->time.begin);
      EXPECT_EQ(after->time.end, before->time.end);
      EXPECT_EQ(after->tetrahedra, made.report.cells);
      EXPECT_LT(made.report.cells, before->tetrahedra * 6 / 10);
    }
  }
}

TEST(Simplify, SlicesAreClosedAndKeepTheirTopology) {
  std::mt19937 random(4);
  for (const model::Mesh& mesh : simplifySamples()) {
    const auto made = simplified(mesh, {.ratio = 0.3, .timeScale = 4});
    const model::TimeSpan span = model::timeSpanOf(mesh);
    for (int i = 0; i < 30; ++i) {
      const double time = std::uniform_real_distribution(span.begin, span.end)(random);
      const model::TriangleMesh before = solidAt(mesh, time);
      const model::TriangleMesh after = solidAt(made.mesh, time);
      EXPECT_TRUE(model::isClosed(after));
      const auto euler = [](const model::TriangleMesh& surface) {
        return static_cast<std::int64_t>(surface.vertices.size()) -
               static_cast<std::int64_t>(surface.triangles.size() / 2);
      };
      EXPECT_EQ(euler(after), euler(before)) << time;
    }
    for (const double time : {span.begin, span.end}) {
      EXPECT_TRUE(model::isClosed(solidAt(made.mesh, time)));
      EXPECT_GT(model::signedVolume(solidAt(made.mesh, time)), 0);
    }
  }
}

TEST(Simplify, NoSliceIsFartherThanTheLargestErrorFromTheOriginal) {
  std::mt19937 random(5);
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(2, {1, 1, 1}), 3);
  constexpr double kMaxError = 0.3;
  for (const SimplifyOptions& options :
       {SimplifyOptions{.maxError = kMaxError, .timeScale = 2},
        SimplifyOptions{
            .ratio = 0.4, .maxError = kMaxError, .timeScale = 2, .windowCells = 3000}}) {
    const auto made = simplified(mesh, options);
    EXPECT_EQ(made.report.maxError, kMaxError);
    EXPECT_LT(made.report.cells, made.report.cellsBefore * 6 / 10);
    const model::TimeSpan span = model::timeSpanOf(mesh);
    for (int i = 0; i < 100; ++i) {
      const double time = std::uniform_real_distribution(span.begin, span.end)(random);
      const auto distance = measure::surfaceDistance(solidAt(mesh, time), solidAt(made.mesh, time));
      EXPECT_LE(distance.hausdorff(), kMaxError);
    }
  }
}

/// A torus that is carried along a random screw.
model::Mesh wovenTorusInScrew(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution(least, most)(random);
  };
  constexpr double kDuration = 24;
  const model::Point3 axis =
      model::Point3(between(-1, 1), between(-1, 1), between(1, 2)).normalized();
  const double turn = between(1, 3);
  const double advance = between(2, 6);
  const auto field = [=](const model::Point3& p, double time) {
    const double part = time / kDuration;
    const model::Point3 own =
        Eigen::AngleAxisd(-turn * part, axis) * (p - advance * part * axis).eval();
    return std::hypot(std::hypot(own[0], own[1]) - 8, own[2]) - 4;
  };
  fixtures::Field torus;
  torus.value = field;
  torus.box.add(model::Point3::Constant(-15));
  torus.box.add(model::Point3::Constant(20));
  torus.timeEnd = kDuration;
  return wovenField(torus, 25);
}

TEST(Simplify, AWovenTorusInAScrewReachesItsRatio) {
  constexpr double kRatio = 0.1;
  for (const std::uint32_t seed : {1, 2}) {
    const model::Mesh mesh = wovenTorusInScrew(seed);
    const auto before = measure::checkMesh(mesh);
    ASSERT_TRUE(before && before->valid());
    const auto made = simplified(
        mesh, {.ratio = kRatio, .timeScale = 0.5, .windowCells = before->tetrahedra / 5});
    const auto after = measure::checkMesh(made.mesh, {.vertexLinks = true});
    ASSERT_TRUE(after && after->valid()) << seed;
    EXPECT_LE(static_cast<double>(after->tetrahedra),
              1.1 * kRatio * static_cast<double>(before->tetrahedra))
        << seed;
    EXPECT_NEAR(after->hypervolume, before->hypervolume, 1e-11 * before->hypervolume);
    EXPECT_LT(made.mesh.slabCount(), 6U);
    for (const double time : {0.0, 3.3, 12.0, 20.9, 24.0}) {
      EXPECT_EQ(measure::generaOf(solidAt(made.mesh, time)), std::vector{1.0}) << time;
    }
  }
}

TEST(Simplify, StopsWhenTold) {
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(4, {3, 1, 2}), 8);
  model::Mesh result;
  const auto report = simplify(mesh, {.ratio = 0.2, .timeScale = 4, .windowSlabs = 2}, result,
                               [](double) { return false; });
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "stopped");
}

TEST(Simplify, TheNumberOfThreadsDoesNotMatter) {
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(4, {3, 1, 2}), 8);
  std::vector<measure::MeshDigest> digests;
  for (const std::size_t threads : {1, 2, 5}) {
    const model::ThreadLimit limit(threads);
    for (const SimplifyOptions& options :
         {SimplifyOptions{.ratio = 0.2, .timeScale = 4, .windowSlabs = 2},
          SimplifyOptions{.ratio = 0.2, .timeScale = 4, .windowCells = 3000}}) {
      const auto made = simplified(mesh, options);
      measure::MeshDigester digester;
      ASSERT_TRUE(model::pump(made.mesh, digester));
      digests.push_back(digester.digest());
    }
  }
  for (std::size_t i = 2; i < digests.size(); ++i) EXPECT_EQ(digests[i], digests[i - 2]);
}

TEST(Simplify, LayersBetweenWindowsAreSharedAndTimesKept) {
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(4, {3, 1, 2}), 8);
  const auto made = simplified(mesh, {.ratio = 0.3, .timeScale = 4, .windowSlabs = 2});
  ASSERT_GT(made.mesh.slabCount(), 4U);
  for (std::size_t i = 1; i < made.mesh.slabCount(); ++i) {
    const model::Slab& below = made.mesh.slabs()[i - 1];
    const model::Slab& above = made.mesh.slabs()[i];
    EXPECT_EQ(below.timeEnd, above.timeBegin);
    EXPECT_TRUE(std::ranges::equal(below.upperLayer(), above.lowerLayer()));
  }
}

TEST(Simplify, PartsFitTogetherAndAddUp) {
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(4, {3, 1, 2}), 8);
  const auto before = measure::checkMesh(mesh);
  SimplifyOptions options{.ratio = 0.3, .timeScale = 4, .windowSlabs = 1};
  for (const std::uint64_t count : {2, 3, 5}) {
    model::Mesh all;
    SimplifyReport sum;
    for (std::uint64_t number = 1; number <= count; ++number) {
      options.part = {number, count};
      const auto made = simplified(mesh, options);
      EXPECT_EQ(made.report.slabs[0], sum.slabs[1]);
      sum.slabs[1] = made.report.slabs[1];
      sum.cellsBefore += made.report.cellsBefore;
      sum.cells += made.report.cells;
      sum.hypervolumeBefore += made.report.hypervolumeBefore;
      sum.hypervolume += made.report.hypervolume;
      for (const model::Slab& slab : made.mesh.slabs()) ASSERT_TRUE(all.put(slab));
    }
    const auto after = measure::checkMesh(all, {.vertexLinks = true});
    ASSERT_TRUE(after && after->valid()) << count;
    EXPECT_EQ(sum.slabs[1], mesh.slabCount());
    EXPECT_EQ(sum.cellsBefore, before->tetrahedra);
    EXPECT_EQ(sum.cells, after->tetrahedra);
    EXPECT_LT(sum.cells, sum.cellsBefore * 7 / 10);
    EXPECT_NEAR(after->hypervolume, before->hypervolume, 1e-11 * before->hypervolume);
    EXPECT_NEAR(sum.hypervolumeBefore, before->hypervolume, 1e-11 * before->hypervolume);
    EXPECT_NEAR(sum.hypervolume, after->hypervolume, 1e-11 * before->hypervolume);
  }
  options.part = {1, mesh.slabCount() + 1};
  model::Mesh into;
  const auto tooMany = simplify(mesh, options, into);
  ASSERT_FALSE(tooMany);
  EXPECT_EQ(tooMany.error().code, ErrorCode::Options);
}

/// The mesh with an attribute `half` of cells, 1 beyond x = middle, and one of vertices, `warmth`,
/// x + 2 t.
model::Mesh withAttributes(const model::Mesh& mesh, double middle) {
  model::Mesh made;
  for (model::Slab slab : mesh.slabs()) {
    auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
    std::vector<std::uint8_t> half;
    for (const model::Cell& cell : connectivity->cells) {
      double x = 0;
      for (const std::uint32_t corner : cell) x += slab.vertices[corner][0] / 4;
      half.push_back(x > middle ? 1 : 0);
    }
    std::vector<double> warmth;
    for (const model::Point4& at : slab.vertices) warmth.push_back(at[0] + 2 * at[3]);
    connectivity->cellAttributes.push_back(model::makeAttribute("half", model::Domain::Cell, half));
    slab.attributes.push_back(model::makeAttribute("warmth", model::Domain::Vertex, warmth));
    slab.connectivity = std::move(connectivity);
    EXPECT_TRUE(made.put(slab));
  }
  return made;
}

/// How far the vertices between cells of two halves are from the plane that parts them.
double farthestBorder(const model::Mesh& mesh, double middle) {
  double farthest = 0;
  for (const model::Slab& slab : mesh.slabs()) {
    auto attributes = slab.connectivity->cellAttributes;
    attributes.insert(attributes.end(), slab.attributes.begin(), slab.attributes.end());
    const auto half = std::ranges::find(attributes, "half", &model::Attribute::name);
    if (half == attributes.end()) {
      ADD_FAILURE() << "a slab has lost the attribute";
      return 0;
    }
    std::vector<int> seen(slab.vertices.size());
    for (std::size_t i = 0; i < slab.connectivity->cells.size(); ++i) {
      const int seenHere = 1 << static_cast<int>(*half->row(i));
      for (const std::uint32_t corner : slab.connectivity->cells[i]) seen[corner] |= seenHere;
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[i] == 3) farthest = std::max(farthest, std::abs(slab.vertices[i][0] - middle));
    }
  }
  return farthest;
}

TEST(Simplify, BordersBetweenValuesStayAndAttributesOfVerticesAreInterpolated) {
  constexpr double kMiddle = 1.5;
  const model::Mesh mesh =
      withAttributes(wovenField(fixtures::translatingSphere(8, {3, 1, 2}), 8), kMiddle);
  const double before = farthestBorder(mesh, kMiddle);
  const SimplifyOptions options{.ratio = 0.2, .timeScale = 4};
  EXPECT_GT(farthestBorder(simplified(mesh, options).mesh, kMiddle), before + 1);
  SimplifyOptions preserving = options;
  preserving.preserve = "half";
  const auto made = simplified(mesh, preserving);
  EXPECT_LT(made.report.cells, made.report.cellsBefore * 3 / 10);
  EXPECT_LT(farthestBorder(made.mesh, kMiddle), before + 0.75);
  EXPECT_TRUE(made.report.droppedAttributes.empty());
  for (const model::Slab& slab : made.mesh.slabs()) {
    const auto its = std::ranges::find(slab.attributes, "warmth", &model::Attribute::name);
    ASSERT_NE(its, slab.attributes.end());
    for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
      double warmth = 0;
      std::memcpy(&warmth, its->row(i), sizeof(warmth));
      EXPECT_NEAR(warmth, slab.vertices[i][0] + 2 * slab.vertices[i][3], 1) << i;
    }
  }
}

TEST(Simplify, AFlatFaceThatMovesStraightNeedsFewCells) {
  model::Mesh mesh;
  for (const auto& named : fixtures::allMotions()) {
    if (named.name != "paper-translation") continue;
    ASSERT_TRUE(mesh4d::sweep(fixtures::paperCube(), *formats::parseMotion(named.json, named.name),
                              {mesh4d::StepsPerSegment{1}, mesh4d::CapMethod::Cone}, mesh));
  }
  ASSERT_GT(mesh.slabCount(), 2U);
  const auto made = simplified(mesh, {.ratio = 0.2, .timeScale = 1});
  EXPECT_LE(made.report.cells, 4600U);
  EXPECT_NEAR(made.report.hypervolume, 512000, 1e-6);
  for (const double time : {0.0, 13.7, 40.2, 64.0}) {
    EXPECT_NEAR(model::signedVolume(solidAt(made.mesh, time)), 8000, 40);
  }
}

model::Mesh moved(const model::Mesh& mesh, const Eigen::Vector3d& by) {
  model::Mesh made;
  for (model::Slab slab : mesh.slabs()) {
    for (model::Point4& vertex : slab.vertices) vertex.head<3>() += by;
    EXPECT_TRUE(made.put(slab));
  }
  return made;
}

TEST(Simplify, AStraightMotionIsProvedFromFewCellsNearAndFar) {
  model::Mesh swept;
  const auto motions = fixtures::allMotions();
  const auto straight =
      std::ranges::find(motions, "paper-translation", &fixtures::NamedMotion::name);
  ASSERT_NE(straight, motions.end());
  ASSERT_TRUE(mesh4d::sweep(fixtures::paperCube(),
                            *formats::parseMotion(straight->json, straight->name),
                            {mesh4d::StepsPerSegment{1}, mesh4d::CapMethod::Cone}, swept));
  for (const double far : {0.0, 1e7}) {
    const model::Mesh mesh = moved(swept, {far, -2 * far, far});
    constexpr double kMaxError = 0.1;
    const auto made = simplified(mesh, {.maxError = kMaxError, .timeScale = 0.25});
    EXPECT_LE(made.report.cells, made.report.cellsBefore / 20);
    EXPECT_NEAR(made.report.hypervolume, 512000, 1e-6 + 1e-12 * far * 512000);
    for (const double time : {0.0, 0.3, 13.7, 40.2, 63.99}) {
      const auto distance = measure::surfaceDistance(solidAt(mesh, time), solidAt(made.mesh, time));
      EXPECT_LE(distance.hausdorff(), kMaxError) << time;
    }
  }
}

TEST(Simplify, WhatCannotBeDoneIsRefused) {
  const model::Mesh mesh = wovenField(fixtures::translatingSphere(2, {1, 1, 1}), 3);
  model::Mesh into;
  for (const SimplifyOptions& wrong :
       {SimplifyOptions{}, SimplifyOptions{.ratio = 0.0}, SimplifyOptions{.ratio = 1.5},
        SimplifyOptions{.maxError = -1.0}, SimplifyOptions{.ratio = 0.5, .timeScale = 0},
        SimplifyOptions{.ratio = 0.5, .preserve = "label"}}) {
    const auto done = simplify(mesh, wrong, into);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::Options);
  }
  model::Mesh open;
  for (std::size_t i = 1; i < mesh.slabCount(); ++i) ASSERT_TRUE(open.put(mesh.slabs()[i]));
  const auto done = simplify(open, {.ratio = 0.5}, into);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().remedy, Remedy::Recover);
}

}  // namespace
}  // namespace t4d::edit
