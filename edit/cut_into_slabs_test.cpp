#include <Eigen/LU>
#include <gtest/gtest.h>

#include "fixtures/polytopes.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;

/// A polytope turned out of the axes, so that its vertices have many times.
Mesh4d turned(const fixtures::Polytope& polytope) {
  Mesh4d mesh{polytope.name, polytope.vertices, fixtures::tetrahedra(polytope)};
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int a = 0; a < 4; ++a) {
    for (int b = a + 1; b < 4; ++b) {
      Eigen::Matrix4d plane = Eigen::Matrix4d::Identity();
      const double angle = 0.3 + 0.4 * a + 0.2 * b;
      plane(a, a) = plane(b, b) = std::cos(angle);
      plane(a, b) = -std::sin(angle);
      plane(b, a) = std::sin(angle);
      matrix = plane * matrix;
    }
  }
  for (model::Point4& vertex : mesh.vertices) vertex = matrix * vertex;
  return mesh;
}

TEST(CutIntoSlabs, KeepsClosedOrientedHypervolumeAndSlices) {
  for (const fixtures::Polytope& polytope : {fixtures::cell16(), fixtures::cell600()}) {
    const auto whole = cutIntoSlabs(turned(polytope), {.slabs = 1});
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->mesh.slabCount(), 1U);
    EXPECT_EQ(whole->splitTetrahedra, 0U);
    for (const std::uint64_t slabs : {2, 7, 1000}) {
      SCOPED_TRACE(polytope.name + " in " + std::to_string(slabs));
      const auto cut = cutIntoSlabs(turned(polytope), {.slabs = slabs});
      ASSERT_TRUE(cut) << cut.error().text();
      const std::size_t most = polytope.vertices.size() - 1;
      EXPECT_EQ(cut->mesh.slabCount(), std::min<std::size_t>(slabs, most));
      const auto report = measure::checkMesh(cut->mesh, {.vertexLinks = true});
      ASSERT_TRUE(report) << report.error().text();
      EXPECT_TRUE(report->valid()) << report->issues.issues.front().message;
      EXPECT_TRUE(report->closed && report->oriented && *report->vertexLinksOk);
      EXPECT_NEAR(report->hypervolume, polytope.hypervolume, 1e-12);
      EXPECT_EQ(report->vertices, polytope.vertices.size() + cut->newVertices);
      const model::TimeSpan span = model::timeSpanOf(whole->mesh);
      for (const double fraction : {0.01, 0.3, 0.5, 0.87}) {
        const double time = span.begin + fraction * (span.end - span.begin);
        const auto before = slice::slice(whole->mesh, slice::Hyperplane::atTime(time));
        const auto after = slice::slice(cut->mesh, slice::Hyperplane::atTime(time));
        ASSERT_TRUE(before && after);
        EXPECT_TRUE(model::isClosed(after->mesh));
        EXPECT_NEAR(model::signedVolume(after->mesh), model::signedVolume(before->mesh), 1e-12);
      }
    }
  }
}

TEST(CutIntoSlabs, RefusesToSplitTwoTetrahedraWithTheSameCorners) {
  const Mesh4d twins = {
      "", {{0, 0, 0, 0}, {1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3}}, {{0, 1, 2, 3}, {1, 0, 2, 3}}};
  EXPECT_TRUE(cutIntoSlabs(twins));
  EXPECT_FALSE(cutIntoSlabs(twins, {.slabs = 2}));
}

TEST(CutIntoSlabs, ASweepGetsItsLayersBackAndNoTetrahedronIsSplit) {
  model::ScrewRun step;
  step.duration = 1;
  step.screw.translation = {0, 0, 1};
  step.count = 64;
  const auto motion = model::chainScrews(0, {&step, 1});
  model::Mesh swept;
  ASSERT_TRUE(motion);
  ASSERT_TRUE(
      mesh4d::sweep(fixtures::paperCube(), *motion, {.caps = mesh4d::CapMethod::Cone}, swept));
  const auto flat = model::flatten(swept);
  ASSERT_TRUE(flat);
  Mesh4d mesh;
  for (Eigen::Index i = 0; i < flat->vertices.rows(); ++i) {
    mesh.vertices.emplace_back(flat->vertices.row(i));
  }
  for (Eigen::Index i = 0; i < flat->cells.rows(); ++i) {
    mesh.cells.push_back(
        {flat->cells(i, 0), flat->cells(i, 1), flat->cells(i, 2), flat->cells(i, 3)});
  }
  const auto cut = cutIntoSlabs(mesh);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->mesh.slabCount(), 64U);
  EXPECT_EQ(cut->splitTetrahedra, 0U);
  const auto report = measure::checkMesh(cut->mesh);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->valid());
  EXPECT_EQ(report->vertices, 4752U);  // with the apexes of two cones
  EXPECT_EQ(report->tetrahedra, 21552U);
}

}  // namespace
}  // namespace t4d::edit
