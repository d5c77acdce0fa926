#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/motion.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// Closing any subset of the slabs of a closed mesh gives a closed mesh, with the hypervolume and
/// the slices of those slabs.
namespace t4d::edit {
namespace {

constexpr double kRounding = 1e-9;

struct Sample {
  std::string name;
  model::Mesh mesh;
};

std::vector<Sample> samples() {
  std::vector<Sample> list;
  const auto motions = fixtures::allMotions();
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    if (solid.name == "bolt") continue;  // large, and nothing new
    for (const fixtures::NamedMotion& motion : motions) {
      auto& [name, mesh] = list.emplace_back();
      name = solid.name + " along " + motion.name;
      const auto report = mesh4d::sweep(
          solid.mesh, *formats::parseMotion(motion.json, motion.name),
          {mesh4d::StepsPerSegment{2}, mesh4d::CapMethod::Cone, mesh4d::PrismSplit::Fourteen},
          mesh);
      EXPECT_TRUE(report) << report.error().text();
    }
  }
  for (const fixtures::Field& field : fixtures::allFields()) {
    auto& [name, mesh] = list.emplace_back();
    name = field.name;
    const auto frames = field.slope == 0 ? static_cast<std::size_t>(field.timeEnd + 1) : 9U;
    const auto source = voxel4d::sampledFrames(
        field.value, {}, field.box, model::evenTimes({field.timeBegin, field.timeEnd}, frames),
        {.slope = field.slope});
    const auto report = voxel4d::weave(*source, {}, mesh);
    EXPECT_TRUE(report) << report.error().text();
  }
  return list;
}

struct Closed {
  model::Mesh mesh;
  std::vector<RunEnd> ends;
  double hypervolume = 0;
};

/// The slabs for which `kept` is true, closed.
Closed closedFrom(std::span<const model::Slab> slabs, const std::vector<bool>& kept) {
  Closed closed;
  RunCloser closer(closed.mesh);
  bool enclosing = false;
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    if (!kept[i]) continue;
    EXPECT_TRUE(closer.put(slabs[i]));
    enclosing = enclosing ||
                (slabs[i].timeBegin < slabs[i].timeEnd && !slabs[i].connectivity->cells.empty());
  }
  auto ends = closer.finish();
  EXPECT_TRUE(ends) << ends.error().text();
  closed.ends = std::move(*ends);
  const auto report = *measure::checkMesh(closed.mesh);
  EXPECT_TRUE(report.closed && report.oriented);
  // Caps alone, and slabs without cells, enclose nothing, which is a separate error.
  EXPECT_EQ(report.issues.errors, enclosing ? 0U : 1U)
      << (report.issues.issues.empty() ? "" : report.issues.issues.front().message);
  for (const RunEnd& end : closed.ends) EXPECT_FALSE(end.open) << *end.open;
  closed.hypervolume = report.hypervolume;
  return closed;
}

/// A solid that rises by 1 a step; slab 0 and the last are its ends.
model::Mesh sweptUp(const model::TriangleMesh& solid, std::uint64_t steps) {
  const model::ScrewRun run{1, {.translation = {0, 0, 1}}, steps};
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, *model::chainScrews(0, {&run, 1}),
                            {{}, mesh4d::CapMethod::Cone, mesh4d::PrismSplit::Fourteen}, mesh));
  return mesh;
}

void expectSameSlice(model::Mesh& closed, model::Mesh& original, double time) {
  const auto found = slice::sliceAtTime(closed, time);
  const auto expected = slice::sliceAtTime(original, time);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_TRUE(expected) << expected.error().text();
  EXPECT_EQ(found->mesh.vertices, expected->mesh.vertices);
  EXPECT_EQ(found->mesh.triangles, expected->mesh.triangles);
  EXPECT_EQ(found->mesh.attributes, expected->mesh.attributes);
}

TEST(CloseRuns, WholeMeshesStayAsTheyAre) {
  for (Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const auto slabs = sample.mesh.slabs();
    const Closed closed = closedFrom(slabs, std::vector<bool>(slabs.size(), true));
    EXPECT_EQ(closed.mesh.slabs().size(), slabs.size());
    EXPECT_TRUE(closed.ends.empty());
  }
}

TEST(CloseRuns, LayersThatDifferInTheSignOfZeroHangTogether) {
  model::Screw up;
  up.translation = {0, 0, 1};
  const model::ScrewRun run{1, up, 2};
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::paperCube(2), *model::chainScrews(0, {&run, 1}),
                            {{}, mesh4d::CapMethod::Cone, mesh4d::PrismSplit::Fourteen}, mesh));
  std::vector<model::Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  for (model::Point4& vertex : slabs[2].vertices) {
    for (double& number : vertex) number = number == 0 ? -0.0 : number;
  }
  const Closed closed = closedFrom(slabs, std::vector<bool>(slabs.size(), true));
  EXPECT_EQ(closed.mesh.slabs().size(), slabs.size());
  EXPECT_TRUE(closed.ends.empty());
}

TEST(CloseRuns, EverySlabAloneIsClosedAndTheirHypervolumesAddUp) {
  for (Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const auto slabs = sample.mesh.slabs();
    double sum = 0;
    double largest = 0;
    for (std::size_t i = 0; i < slabs.size(); ++i) {
      std::vector<bool> kept(slabs.size(), false);
      kept[i] = true;
      const double hypervolume = closedFrom(slabs, kept).hypervolume;
      sum += hypervolume;
      largest = std::max(largest, hypervolume);
    }
    EXPECT_NEAR(sum, measure::checkMesh(sample.mesh)->hypervolume, largest * kRounding);
  }
}

TEST(CloseRuns, SomeSlabsKeepTheirSlices) {
  std::mt19937 random(11);
  for (Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const auto slabs = sample.mesh.slabs();
    for (const double share : {0.3, 0.7, 0.9}) {
      std::vector<bool> kept(slabs.size());
      for (std::size_t i = 0; i < kept.size(); ++i) {
        kept[i] = std::bernoulli_distribution(share)(random);
      }
      Closed closed = closedFrom(slabs, kept);
      for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto& [begin, end] = std::tie(slabs[i].timeBegin, slabs[i].timeEnd);
        if (!kept[i] || begin == end) continue;
        expectSameSlice(closed.mesh, sample.mesh, begin);
        expectSameSlice(closed.mesh, sample.mesh, begin + 0.37 * (end - begin));
      }
    }
  }
}

TEST(CloseRuns, BeginningOfASweepHasTheHypervolumeOfTheLaw) {
  model::Screw screw;
  screw.axisPoint = {30, 4, 0};
  screw.axisDirection = {1, 2, 3};
  screw.angleDegrees = 90;
  screw.translation = {5, 0, 1};
  const model::ScrewRun run{2, screw, 1};
  constexpr std::uint64_t kSteps = 9;
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(
      fixtures::cube(20), *model::chainScrews(0, {&run, 1}),
      {mesh4d::StepsPerSegment{kSteps}, mesh4d::CapMethod::Cone, mesh4d::PrismSplit::Fourteen},
      mesh));
  const double theta = std::numbers::pi / 2 / kSteps;
  for (std::size_t steps = 1; steps <= kSteps; ++steps) {
    std::vector<bool> kept(mesh.slabs().size(), false);
    std::fill_n(kept.begin(), steps + 1, true);
    const Closed closed = closedFrom(mesh.slabs(), kept);
    const double dt = 2.0 / kSteps;
    EXPECT_NEAR(closed.hypervolume,
                8000 * dt * (2 + std::cos(theta)) / 3 * static_cast<double>(steps),
                8000 * 2 * kRounding);
    ASSERT_EQ(closed.ends.size(), 1U);
    EXPECT_FALSE(closed.ends[0].begin);
    EXPECT_EQ(closed.ends[0].slab, steps);
    EXPECT_EQ(closed.ends[0].triangles, 12U);
    EXPECT_EQ(closed.ends[0].time, mesh.slabs()[steps].timeEnd);
  }
}

TEST(CloseRuns, CapsAreMarkedInTheAttributesOfCells) {
  const model::Mesh mesh = sweptUp(fixtures::twoBoxes(2, 1), 3);
  const Closed closed = closedFrom(mesh.slabs(), {false, false, true, false, false});
  ASSERT_EQ(closed.mesh.slabs().size(), 3U);
  for (const std::size_t at : {0U, 2U}) {
    const model::Slab& cap = closed.mesh.slabs()[at];
    // One apex for each of the boxes.
    EXPECT_EQ(cap.vertices.size(), 16U + 2U);
    EXPECT_EQ(cap.connectivity->cells.size(), 24U);
    for (const model::Attribute& attribute : cap.connectivity->cellAttributes) {
      if (attribute.name == "kind") {
        EXPECT_EQ(attribute.values, std::vector(24, at == 0 ? std::byte{1} : std::byte{2}));
      } else {
        EXPECT_EQ(attribute.name, "triangle");
        EXPECT_EQ(attribute.values, std::vector(4 * 24, std::byte{0xFF}));
      }
    }
  }
}

TEST(CloseRuns, CapsHaveTheAttributesOfTheCellsBesideThem) {
  const model::Mesh mesh = sweptUp(fixtures::cube(2), 3);
  model::Slab slab = mesh.slabs()[2];
  auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
  const std::vector<std::uint32_t> labels(connectivity->cells.size(), 7);
  const std::vector<float> triangles(connectivity->cells.size(), 0.5F);
  connectivity->cellAttributes = {model::makeAttribute("label", model::Domain::Cell, labels),
                                  model::makeAttribute("triangle", model::Domain::Cell, triangles)};
  slab.connectivity = connectivity;
  const Closed closed = closedFrom({&slab, 1}, {true});
  ASSERT_EQ(closed.mesh.slabs().size(), 3U);
  for (const std::size_t at : {0U, 2U}) {
    const model::Connectivity& cap = *closed.mesh.slabs()[at].connectivity;
    ASSERT_EQ(cap.cells.size(), 12U);
    EXPECT_EQ(
        cap.cellAttributes,
        (std::vector{
            model::makeAttribute("label", model::Domain::Cell, std::vector<std::uint32_t>(12, 7)),
            model::makeAttribute("triangle", model::Domain::Cell, std::vector<float>(12, 0.5F))}));
  }
}

TEST(CloseRuns, VerticesOfALayerKeepTheirAttributes) {
  const model::Mesh mesh = sweptUp(fixtures::cube(2), 2);
  model::Slab slab = mesh.slabs()[1];
  std::vector<float> numbers(slab.vertices.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<float>(i);
  slab.attributes.push_back(model::makeAttribute("number", model::Domain::Vertex, numbers));
  // This also checks that both sides of a seam match.
  Closed closed = closedFrom({&slab, 1}, {true});
  ASSERT_EQ(closed.mesh.slabs().size(), 3U);
  const auto slice = slice::sliceAtTime(closed.mesh, 1);
  ASSERT_EQ(slice->mesh.attributes.size(), 1U + 2U);
}

TEST(CloseRuns, WhatIsNotClosedElsewhereStaysOpenAndSaysWhere) {
  const model::Mesh mesh = sweptUp(fixtures::cube(2), 3);
  std::vector<model::Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  auto torn = std::make_shared<model::Connectivity>(*slabs[1].connectivity);
  torn->cells.resize(torn->cells.size() - 14);
  torn->cellAttributes.clear();
  slabs[1].connectivity = torn;
  model::Mesh made;
  RunCloser closer(made);
  for (const std::size_t i : {0U, 1U, 3U, 4U}) ASSERT_TRUE(closer.put(slabs[i]));
  const auto ends = closer.finish();
  ASSERT_TRUE(ends);
  ASSERT_EQ(ends->size(), 2U);
  ASSERT_TRUE(ends->front().open);
  EXPECT_NE(ends->front().open->find("edge"), std::string::npos) << *ends->front().open;
  EXPECT_FALSE(ends->back().open);
  // Each layer still joins an empty one, so that the slabs fit into one file.
  ASSERT_EQ(made.slabs().size(), 6U);
  EXPECT_TRUE(made.slabs()[2].connectivity->cells.empty());
  EXPECT_EQ(made.slabs()[2].connectivity->lowerCount, 8U);
  EXPECT_EQ(made.slabs()[2].connectivity->upperCount, 0U);
}

}  // namespace
}  // namespace t4d::edit
