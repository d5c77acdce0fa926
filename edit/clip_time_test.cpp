#include "edit/clip_time.h"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/polytopes.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// The parts of a closed mesh between two times are closed meshes with its slices, and of those
/// that follow one another the hypervolumes add up.
namespace t4d::edit {
namespace {

struct ClipSample {
  std::string name;
  model::Mesh mesh;
};

std::vector<ClipSample> clipSamples() {
  std::vector<ClipSample> list;
  const auto motions = fixtures::allMotions();
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    if (solid.name == "bolt") continue;
    const fixtures::NamedMotion& motion = motions[list.size() % motions.size()];
    auto& [name, mesh] = list.emplace_back();
    name = solid.name + " along " + motion.name;
    const auto report = mesh4d::sweep(solid.mesh, *formats::parseMotion(motion.json, motion.name),
                                      {mesh4d::StepsPerSegment{3}, mesh4d::CapMethod::Cone}, mesh);
    EXPECT_TRUE(report) << report.error().text();
  }
  for (const fixtures::Field& field : fixtures::allFields()) {
    auto& [name, mesh] = list.emplace_back();
    name = field.name;
    const auto frames = field.slope == 0 ? static_cast<std::size_t>(field.timeEnd + 1) : 5U;
    const auto source = voxel4d::sampledFrames(
        field.value, {}, field.box, model::evenTimes({field.timeBegin, field.timeEnd}, frames),
        {.slope = field.slope});
    EXPECT_TRUE(voxel4d::weave(*source, {}, mesh));
  }
  const fixtures::Polytope polytope = fixtures::cell600();
  auto cut = cutIntoSlabs({polytope.name, polytope.vertices, fixtures::tetrahedra(polytope)});
  EXPECT_TRUE(cut);
  list.push_back({polytope.name, std::move(cut->mesh)});
  return list;
}

double volumeAt(const model::Source& mesh, double time) {
  const auto slice = slice::slice(mesh, slice::Hyperplane::atTime(time));
  EXPECT_TRUE(slice) << slice.error().text();
  EXPECT_TRUE(model::isClosed(slice->mesh));
  return model::signedVolume(slice->mesh);
}

TEST(ClipTime, PartsAreClosedAndHaveTheSlicesAndTogetherTheHypervolumeOfTheWhole) {
  std::mt19937 random(20);
  for (const auto& [name, mesh] : clipSamples()) {
    SCOPED_TRACE(name);
    const model::TimeSpan whole = model::timeSpanOf(mesh);
    const auto report = measure::checkMesh(mesh);
    ASSERT_TRUE(report && report->valid());
    // Anywhere, and at layers.
    std::vector<double> times = {whole.begin, whole.end};
    for (int i = 0; i < 3; ++i) {
      times.push_back(std::uniform_real_distribution(whole.begin, whole.end)(random));
      times.push_back(mesh.timeSpan(random() % mesh.slabCount()).end);
    }
    std::ranges::sort(times);
    times.erase(std::unique(times.begin(), times.end()), times.end());
    double hypervolume = 0;
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      const model::TimeSpan span{times[i], times[i + 1]};
      SCOPED_TRACE(std::to_string(span.begin) + " to " + std::to_string(span.end));
      model::Mesh part;
      const auto clip = clipTime(mesh, span, part);
      ASSERT_TRUE(clip) << clip.error().text();
      if (clip->cells == 0) continue;
      const auto checked = measure::checkMesh(part);
      ASSERT_TRUE(checked) << checked.error().text();
      EXPECT_TRUE(checked->valid()) << checked->issues.issues.front().message;
      EXPECT_TRUE(checked->closed && checked->oriented);
      EXPECT_GE(model::timeSpanOf(part).begin, span.begin);
      EXPECT_LE(model::timeSpanOf(part).end, span.end);
      hypervolume += checked->hypervolume;
      for (const double fraction : {0.2, 0.7}) {
        const double time = std::lerp(span.begin, span.end, fraction);
        const double volume = volumeAt(mesh, time);
        EXPECT_NEAR(volumeAt(part, time), volume, 1e-11 * std::abs(volume) + 1e-12);
      }
    }
    EXPECT_NEAR(hypervolume, report->hypervolume, 1e-11 * std::abs(report->hypervolume));
  }
}

TEST(ClipTime, WholeCellsOfASlabGoToTheSideThatTheyLieOn) {
  // Half way of a step are the centroids of its prisms, at which cells end and others begin.
  const model::ScrewRun run{2, {.angleDegrees = 40, .translation = {1, 2, 3}}, 1};
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::paperCube(2), *model::chainScrews(0, {&run, 1}),
                            {mesh4d::StepsPerSegment{2}, mesh4d::CapMethod::Cone}, mesh));
  double hypervolume = 0;
  for (const model::TimeSpan& span : {model::TimeSpan{0, 0.5}, {0.5, 1.5}, {1.5, 2}}) {
    model::Mesh part;
    ASSERT_TRUE(clipTime(mesh, span, part));
    const auto checked = measure::checkMesh(part);
    ASSERT_TRUE(checked);
    EXPECT_TRUE(checked->valid() && checked->closed && checked->oriented);
    EXPECT_EQ(checked->time.begin, span.begin);
    EXPECT_EQ(checked->time.end, span.end);
    EXPECT_EQ(checked->degenerateCells, 0U);
    for (const model::Slab& slab : part.slabs()) {
      for (const model::Cell& cell : slab.connectivity->cells) {
        for (const std::uint32_t vertex : cell) {
          EXPECT_GE(slab.vertices[vertex][3], span.begin);
          EXPECT_LE(slab.vertices[vertex][3], span.end);
        }
      }
    }
    hypervolume += checked->hypervolume;
  }
  EXPECT_NEAR(hypervolume, measure::checkMesh(mesh)->hypervolume, 1e-12);
}

TEST(ClipTime, TwinCellsAreRefusedOnlyWhereTheyWouldBeSplit) {
  const model::ScrewRun run{2, {.translation = {1, 2, 3}}, 1};
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&run, 1}),
                            {mesh4d::StepsPerSegment{1}, mesh4d::CapMethod::Cone}, mesh));
  model::Slab slab = mesh.slabs()[1];
  auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
  connectivity->cellAttributes.clear();
  // A cell of the first half of the step, twice, with opposite orientations.
  const auto first = std::ranges::find_if(connectivity->cells, [&](const model::Cell& cell) {
    return std::ranges::all_of(cell, [&](std::uint32_t i) { return slab.vertices[i][3] <= 1; });
  });
  ASSERT_NE(first, connectivity->cells.end());
  auto [a, b, c, d] = *first;
  connectivity->cells.push_back({a, b, c, d});
  connectivity->cells.push_back({b, a, c, d});
  slab.connectivity = connectivity;
  model::Mesh twins;
  ASSERT_TRUE(twins.put(mesh.slabs()[0]) && twins.put(slab) && twins.put(mesh.slabs()[2]));
  for (const double end : {1.0, 1.5}) {
    model::Mesh part;
    const auto clipped = clipTime(twins, {0, end}, part);
    EXPECT_TRUE(clipped) << clipped.error().text();
  }
  model::Mesh part;
  const auto split = clipTime(twins, {0, 0.5}, part);
  ASSERT_FALSE(split);
  EXPECT_NE(split.error().message.find("have the same corners"), std::string::npos);
}

TEST(ClipTime, TheWholeSpanChangesNothing) {
  for (const auto& [name, mesh] : clipSamples()) {
    model::Mesh part;
    const auto clip = clipTime(mesh, model::timeSpanOf(mesh), part);
    ASSERT_TRUE(clip) << name << clip.error().text();
    EXPECT_EQ(clip->cutSlabs, 0U);
    EXPECT_TRUE(clip->caps.empty());
    ASSERT_EQ(part.slabCount(), mesh.slabCount());
    for (std::size_t i = 0; i < part.slabCount(); ++i) {
      EXPECT_EQ(part.slabs()[i].vertices, mesh.slabs()[i].vertices);
      EXPECT_EQ(part.slabs()[i].connectivity, mesh.slabs()[i].connectivity);
    }
  }
}

TEST(ClipTime, AttributesAreInterpolatedOverTimeAndThoseOfCellsKept) {
  // Each vertex knows its own x and t.
  for (const auto& [name, mesh] : clipSamples()) {
    model::Mesh told;
    for (model::Slab slab : mesh.slabs()) {
      std::vector<double> places;
      for (const model::Point4& vertex : slab.vertices) {
        places.push_back(vertex.x());
        places.push_back(vertex[3]);
      }
      auto attribute = model::makeAttribute("place", model::Domain::Vertex, places);
      attribute.components = 2;
      slab.attributes = {attribute};
      auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
      std::vector<std::uint32_t> cells(connectivity->cells.size());
      std::iota(cells.begin(), cells.end(), 0U);
      connectivity->cellAttributes = {model::makeAttribute("cell", model::Domain::Cell, cells)};
      slab.connectivity = connectivity;
      ASSERT_TRUE(told.put(slab));
    }
    const model::TimeSpan whole = model::timeSpanOf(mesh);
    model::Mesh part;
    ASSERT_TRUE(clipTime(told, {std::lerp(whole.begin, whole.end, 0.21), whole.end}, part)) << name;
    for (const model::Slab& slab : part.slabs()) {
      if (slab.timeBegin == slab.timeEnd) continue;  // apexes of caps have those of a neighbour
      ASSERT_EQ(slab.attributes.size(), 1U);
      const model::Attribute& attribute = slab.attributes.front();
      ASSERT_EQ(attribute.rows(), slab.vertices.size());
      for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
        double place[2];
        std::memcpy(place, attribute.row(i), sizeof place);
        EXPECT_NEAR(place[0], slab.vertices[i].x(), 1e-11) << name;
        EXPECT_NEAR(place[1], slab.vertices[i][3], 1e-11) << name;
      }
      EXPECT_TRUE(model::checkSlab(slab)) << name;
      EXPECT_EQ(slab.connectivity->cellAttributes.front().rows(), slab.connectivity->cells.size());
    }
  }
}

TEST(ClipTime, NothingLiesBeforeOrAfterTheMesh) {
  const auto samples = clipSamples();
  const model::TimeSpan whole = model::timeSpanOf(samples.front().mesh);
  model::Mesh part;
  ASSERT_TRUE(clipTime(samples.front().mesh, {whole.end + 1, whole.end + 2}, part));
  ASSERT_TRUE(clipTime(samples.front().mesh, {whole.begin - 2, whole.begin}, part));
  ASSERT_TRUE(clipTime(samples.front().mesh, {whole.end, whole.end + 1}, part));
  EXPECT_EQ(part.slabCount(), 0U);
}

}  // namespace
}  // namespace t4d::edit
