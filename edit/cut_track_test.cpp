#include "edit/cut_track.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/solids.h"
#include "measure/surface_genus.h"
#include "measure/woven_noise.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

/// A track that is cut out of a mesh is a valid mesh, which has the slices of its component, and
/// all tracks together have the hypervolume of the whole.
namespace t4d::edit {
namespace {

using measure::boxOf;
using measure::noiseField;
using measure::woven;

/// Some times in a span at which the mesh has no vertex.
std::vector<double> timesWithin(const model::Mesh& mesh, const model::TimeSpan& span) {
  std::set<double> times = {span.begin, span.end};
  for (const model::Slab& slab : mesh.slabs()) {
    for (const model::Point4& vertex : slab.vertices) {
      if (vertex[3] > span.begin && vertex[3] < span.end) times.insert(vertex[3]);
    }
  }
  const std::vector<double> sorted(times.begin(), times.end());
  const std::size_t every = std::max<std::size_t>(1, sorted.size() / 6);
  std::vector<double> between;
  for (std::size_t i = 0; i + 1 < sorted.size(); i += every) {
    const double middle = sorted[i] + (sorted[i + 1] - sorted[i]) / 2;
    if (middle > sorted[i] && middle < sorted[i + 1]) between.push_back(middle);
  }
  return between;
}

/// The measures of a track at a time.
std::optional<measure::SolidMeasures> sampleAt(const measure::Track& track, double time) {
  for (const measure::TrackSample& sample : track.samples) {
    if (sample.measures.time == time) return sample.measures;
  }
  return std::nullopt;
}

void expectIsTrack(const model::Mesh& whole, std::uint32_t number, const model::Mesh& part,
                   const measure::Track& track) {
  measure::TrackOptions options;
  options.layers = false;
  options.times = timesWithin(part, {track.begin, track.end});
  const auto measured = measure::tracksOf(whole, options);
  const auto alone = measure::tracksOf(part, {.times = {}, .layers = false});
  ASSERT_TRUE(measured && alone);
  EXPECT_EQ(alone->tracks.size(), 1U);
  for (const double time : options.times) {
    SCOPED_TRACE(time);
    const auto expected = sampleAt(measured->tracks[number], time);
    ASSERT_TRUE(expected);
    const auto slice = slice::sliceAtTime(part, time);
    ASSERT_TRUE(slice);
    EXPECT_TRUE(isClosed(slice->mesh));
    const measure::SolidMeasures found = measure::measuresOf(slice->mesh);
    EXPECT_NEAR(found.volume, expected->volume, 1e-9 * (1 + expected->volume));
    EXPECT_NEAR(found.area, expected->area, 1e-9 * (1 + expected->area));
    EXPECT_EQ(found.components, 1U);
    EXPECT_EQ(found.cavities, expected->cavities);
    EXPECT_EQ(found.genus, expected->genus);
  }
}

void expectTracksAreCutOut(const model::Mesh& mesh, std::size_t most = 40) {
  const auto tracks = measure::tracksOf(mesh, {.times = {}, .layers = false});
  ASSERT_TRUE(tracks);
  measure::MeshChecker whole;
  ASSERT_TRUE(model::pump(mesh, whole));
  const double hypervolume = whole.finish().hypervolume;
  double sum = 0;
  for (std::uint32_t i = 0; i < tracks->tracks.size(); ++i) {
    SCOPED_TRACE(fmt::format("track {} of {}", i + 1, tracks->tracks.size()));
    model::Mesh part;
    const auto cut = cutTrack(mesh, i, part);
    ASSERT_TRUE(cut) << cut.error().text();
    EXPECT_EQ(cut->span.begin, tracks->tracks[i].begin);
    EXPECT_EQ(cut->span.end, tracks->tracks[i].end);
    measure::MeshChecker checker({.vertexLinks = true});
    ASSERT_TRUE(model::pump(part, checker));
    const measure::MeshReport report = checker.finish();
    EXPECT_EQ(report.issues.errors, 0U)
        << (report.issues.issues.empty() ? "" : report.issues.issues.front().message);
    EXPECT_TRUE(report.closed && report.oriented);
    EXPECT_EQ(report.time.begin, tracks->tracks[i].begin);
    EXPECT_EQ(report.time.end, tracks->tracks[i].end);
    sum += report.hypervolume;
    if (i < most) expectIsTrack(mesh, i, part, tracks->tracks[i]);
  }
  EXPECT_NEAR(sum, hypervolume, 1e-10 * hypervolume);
}

TEST(CutTrack, OfNoise) {
  voxel4d::WeaveOptions midpoints;
  midpoints.between = voxel4d::Between::Midpoint;
  for (std::uint64_t seed = 40; seed < 43; ++seed) {
    for (const double shift : {-0.3, 0.2, 0.55}) {
      SCOPED_TRACE(fmt::format("seed {}, shift {}", seed, shift));
      expectTracksAreCutOut(woven(noiseField(seed, shift), boxOf(4), 0, 4, 4));
      expectTracksAreCutOut(woven(noiseField(seed, shift), boxOf(4), 0, 4, 4, 1, true));
      expectTracksAreCutOut(woven(noiseField(seed, shift), boxOf(4), 0, 4, 4, 1, true, midpoints));
    }
  }
}

TEST(CutTrack, OfFields) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    SCOPED_TRACE(field.name);
    for (const bool mask : {false, true}) {
      expectTracksAreCutOut(
          woven(field.value, field.box, field.timeBegin, field.timeEnd, 6, 1, mask), 10);
    }
  }
}

TEST(CutTrack, OfTwoSweptBoxes) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 170;
  const auto motion = *model::chainScrews(0, {&run, 1});
  for (const auto& solid : {fixtures::twoBoxes(2, 1), fixtures::hollowCube(4, 2)}) {
    model::Mesh mesh;
    ASSERT_TRUE(
        mesh4d::sweep(solid, motion, {mesh4d::StepsPerSegment{5}, mesh4d::CapMethod::Cone}, mesh));
    expectTracksAreCutOut(mesh);
  }
}

TEST(CutTrack, ThatDoesNotExistIsAnError) {
  const model::Mesh mesh = woven(noiseField(1, 0.5), boxOf(3), 0, 2, 2);
  const auto tracks = measure::tracksOf(mesh);
  ASSERT_TRUE(tracks);
  const auto count = static_cast<std::uint32_t>(tracks->tracks.size());
  model::Mesh part;
  const auto cut = cutTrack(mesh, count, part);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().message, fmt::format("has no track {}; it has {}", count + 1, count));
}

}  // namespace
}  // namespace t4d::edit
