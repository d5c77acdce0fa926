#include "measure/track_parts.h"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "measure/woven_noise.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

std::string pointText(const model::Point3& point) {
  return fmt::format("{} {} {}", point.x(), point.y(), point.z());
}

/// All that is known of tracks, digit for digit.
std::string wholeText(const Tracks& tracks) {
  std::string text = fmt::format("{} {} {} {}\n", tracks.time.begin, tracks.time.end,
                                 tracks.prunedTracks, tracks.prunedEvents);
  for (const Track& track : tracks.tracks) {
    text +=
        fmt::format("track {} {} {} {} {} {} {} {}\n", track.begin, track.end, track.beginsWithMesh,
                    track.endsWithMesh, track.cavity, track.from, track.into, track.largestVolume);
    for (const TrackSample& sample : track.samples) {
      const SolidMeasures& one = sample.measures;
      text += fmt::format("  {} {} {} {} {} {} {} {} {} {}\n", one.time, one.volume, one.area,
                          pointText(one.centroid), one.components, one.cavities, one.genus,
                          pointText(one.bounds.min), pointText(one.bounds.max),
                          sample.speed.value_or(-1));
    }
  }
  for (const TrackEvent& event : tracks.events) {
    text +=
        fmt::format("event {} {} {} {} {} {} {}\n", event.time, static_cast<int>(event.kind),
                    pointText(event.place), event.before, event.after, event.count, event.euler);
  }
  for (const BriefCavity& cavity : tracks.briefCavities) {
    text += fmt::format("cavity {} {} {}\n", cavity.appears, cavity.vanishes, cavity.largestVolume);
  }
  return text;
}

std::string joinedText(const model::Source& mesh, const TrackOptions& options,
                       std::uint64_t count) {
  std::vector<PartOfTracks> parts;
  for (std::uint64_t k = 1; k <= count; ++k) {
    auto part = tracksOfPart(mesh, options, model::Part{k, count}.of(mesh.slabCount()));
    EXPECT_TRUE(part) << part.error().text();
    if (!part) return {};
    parts.push_back(std::move(*part));
  }
  const auto joined = joinedTracks(std::move(parts), options);
  EXPECT_TRUE(joined) << joined.error().text();
  return joined ? wholeText(*joined) : std::string();
}

/// Parts of a mesh, cut anywhere, have the tracks of the whole.
void expectPartsJoin(const model::Source& mesh) {
  const auto spans = model::timeSpanOf(mesh);
  std::vector<TrackOptions> each(5);
  each[1].surfaces = true;
  each[2].layers = false;
  each[3].layers = false;
  each[3].surfaces = true;
  each[3].times = model::evenTimes(spans, 4);
  each[4].minVolume = 1.5;
  each[4].minDuration = 0.3;
  for (const TrackOptions& options : each) {
    SCOPED_TRACE(&options - each.data());
    const auto whole = tracksOf(mesh, options);
    ASSERT_TRUE(whole) << whole.error().text();
    const std::string expected = wholeText(*whole);
    for (const std::uint64_t count :
         {std::uint64_t{1}, std::uint64_t{2}, std::uint64_t{3}, std::uint64_t{mesh.slabCount()}}) {
      SCOPED_TRACE(count);
      EXPECT_EQ(joinedText(mesh, options, count), expected);
    }
  }
}

TEST(TrackParts, OfNoiseJoinToTheWhole) {
  voxel4d::WeaveOptions midpoints;
  midpoints.between = voxel4d::Between::Midpoint;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    for (const double shift : {-0.6, 0.0, 0.5}) {
      SCOPED_TRACE(fmt::format("seed {}, shift {}", seed, shift));
      expectPartsJoin(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4));
      expectPartsJoin(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, true));
      expectPartsJoin(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, true, midpoints));
    }
  }
}

TEST(TrackParts, OfFieldsJoinToTheWhole) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    SCOPED_TRACE(field.name);
    expectPartsJoin(woven(field.value, field.box, field.timeBegin, field.timeEnd, 5));
  }
}

TEST(TrackParts, OfSweptSolidsJoinToTheWhole) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 170;
  const auto motion = *model::chainScrews(0, {&run, 1});
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    if (solid.mesh.triangles.size() > 1000) continue;
    SCOPED_TRACE(solid.name);
    model::Mesh mesh;
    ASSERT_TRUE(mesh4d::sweep(solid.mesh, motion,
                              {mesh4d::StepsPerSegment{5}, mesh4d::CapMethod::Cone}, mesh));
    expectPartsJoin(mesh);
  }
}

TEST(TrackParts, ThatDoNotContinueEachOtherAreRefused) {
  const model::Mesh mesh = woven(noiseField(1, 0), boxOf(5), 0, 4, 4);
  std::vector<PartOfTracks> parts;
  for (const std::uint64_t k : {std::uint64_t{1}, std::uint64_t{3}}) {
    parts.push_back(*tracksOfPart(mesh, {}, model::Part{k, 3}.of(mesh.slabCount())));
  }
  EXPECT_FALSE(joinedTracks(std::move(parts), {}));
}

}  // namespace
}  // namespace t4d::measure
