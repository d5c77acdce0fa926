#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/polytopes.h"
#include "fixtures/solids.h"
#include "measure/surface_genus.h"
#include "measure/woven_noise.h"
#include "model/parallel.h"
#include "model/source_part.h"
#include "model/union_find.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::measure {
namespace {

using model::Point3;
using voxel4d::FieldFunction;

Tracks tracksIn(const model::Source& mesh, const TrackOptions& options = {}) {
  auto found = tracksOf(mesh, options);
  EXPECT_TRUE(found) << found.error().text();
  return found ? std::move(*found) : Tracks();
}

std::vector<TrackEventKind> kindsOf(const Tracks& tracks) {
  std::vector<TrackEventKind> kinds;
  for (const TrackEvent& event : tracks.events) kinds.push_back(event.kind);
  return kinds;
}

/// Times that no vertex has, one after every `every` of the times that vertices have.
std::vector<double> timesBetween(const model::Mesh& mesh, std::size_t most) {
  std::set<double> times;
  for (const model::Slab& slab : mesh.slabs()) {
    for (const model::Point4& vertex : slab.vertices) times.insert(vertex[3]);
  }
  const std::vector<double> sorted(times.begin(), times.end());
  std::vector<double> between;
  const std::size_t every = std::max<std::size_t>(1, sorted.size() / most);
  for (std::size_t i = 0; i + 1 < sorted.size(); i += every) {
    const double middle = sorted[i] + (sorted[i + 1] - sorted[i]) / 2;
    if (middle > sorted[i] && middle < sorted[i + 1]) between.push_back(middle);
  }
  return between;
}

/// The slices of a mesh have the components, volumes and Euler numbers that its tracks have.
void expectSlicesAgree(const model::Mesh& mesh, std::size_t most = 40) {
  TrackOptions options;
  options.times = timesBetween(mesh, most);
  options.layers = false;
  const Tracks solids = tracksIn(mesh, options);
  options.surfaces = true;
  const Tracks surfaces = tracksIn(mesh, options);
  double eulerAtBegin = 0;
  bool begun = false;
  for (const double time : options.times) {
    SCOPED_TRACE(time);
    const auto slice = slice::sliceAtTime(mesh, time);
    ASSERT_TRUE(slice);
    std::vector<double> volumes;
    std::vector<double> outward;
    double euler = 0;
    for (const ConnectedSurface& surface : surfacesOf(slice->mesh)) {
      volumes.push_back(surface.volume);
      if (surface.volume > 0) outward.push_back(surface.volume);
      euler += 2 - 2 * surface.genus;
    }
    std::ranges::sort(volumes);
    const auto alive = [&](const Tracks& tracks) {
      return std::ranges::count_if(tracks.tracks, [&](const Track& track) {
        return track.begin < time && time < track.end;
      });
    };
    EXPECT_EQ(alive(solids), std::ssize(outward));
    EXPECT_EQ(alive(surfaces), std::ssize(volumes));
    std::vector<double> found;
    double solidSum = 0;
    double genus = 0;
    std::uint64_t cavities = 0;
    const auto gather = [&](const Tracks& tracks, auto add) {
      for (const Track& track : tracks.tracks) {
        for (const TrackSample& sample : track.samples) {
          if (sample.measures.time == time) add(sample.measures);
        }
      }
    };
    gather(surfaces, [&](const SolidMeasures& one) { found.push_back(one.volume); });
    gather(solids, [&](const SolidMeasures& one) {
      solidSum += one.volume;
      genus += one.genus;
      cavities += one.cavities;
      EXPECT_EQ(one.components, 1U);
      EXPECT_GT(one.volume, 0);
    });
    std::ranges::sort(found);
    ASSERT_EQ(found.size(), volumes.size());
    double sum = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i], volumes[i], 1e-9 * std::abs(volumes[i]) + 1e-13);
      sum += volumes[i];
    }
    EXPECT_NEAR(solidSum, sum, 1e-9 * std::abs(sum));
    EXPECT_EQ(cavities, volumes.size() - outward.size());
    EXPECT_EQ(2 * static_cast<double>(volumes.size()) - 2 * genus, euler);
    for (const Tracks* tracks : {&solids, &surfaces}) {
      double changes = 0;
      for (const TrackEvent& event : tracks->events) {
        if (event.time < time) changes += static_cast<double>(event.euler);
      }
      if (!begun) eulerAtBegin = euler - changes;
      begun = true;
      EXPECT_EQ(eulerAtBegin + changes, euler);
    }
  }
}

/// What of a mesh lies between two times is in as many pieces as the tracks of its surfaces there,
/// joined by the events there.
void expectPiecesAgree(const model::Mesh& mesh) {
  TrackOptions options;
  options.surfaces = true;
  const Tracks tracks = tracksIn(mesh, options);
  const std::vector<double> times = timesBetween(mesh, 12);
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (std::size_t j = i + 1; j < times.size(); ++j) {
      const double begin = times[i];
      const double end = times[j];
      std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint32_t> cellOfEdge;
      std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
      std::uint32_t cells = 0;
      std::uint64_t offset = 0;
      for (const model::Slab& slab : mesh.slabs()) {
        for (const model::Cell& cell : slab.connectivity->cells) {
          const auto time = [&](std::uint32_t v) { return slab.vertices[v][3]; };
          const auto [low, high] =
              std::minmax({time(cell[0]), time(cell[1]), time(cell[2]), time(cell[3])});
          if (high <= begin || low >= end) continue;
          for (int a = 0; a < 4; ++a) {
            for (int b = a + 1; b < 4; ++b) {
              const auto [from, to] = std::minmax({time(cell[a]), time(cell[b])});
              if (to <= begin || from >= end) continue;
              const auto [u, w] = std::minmax({offset + cell[a], offset + cell[b]});
              const auto [at, isNew] = cellOfEdge.try_emplace({u, w}, cells);
              if (!isNew) links.emplace_back(at->second, cells);
            }
          }
          ++cells;
        }
        offset += slab.connectivity->firstUpper();
      }
      model::UnionFind ofCells(cells);
      std::uint32_t pieces = cells;
      for (const auto& [a, b] : links) pieces -= ofCells.unite(a, b) ? 1 : 0;

      model::UnionFind ofTracks(tracks.tracks.size());
      std::uint32_t groups = 0;
      for (const Track& track : tracks.tracks) {
        groups += track.begin < end && track.end > begin ? 1 : 0;
      }
      for (const TrackEvent& event : tracks.events) {
        if (event.time <= begin || event.time >= end) continue;
        std::vector<std::uint32_t> all = event.before;
        all.insert(all.end(), event.after.begin(), event.after.end());
        for (std::size_t k = 1; k < all.size(); ++k) {
          groups -= ofTracks.unite(all[0], all[k]) ? 1 : 0;
        }
      }
      EXPECT_EQ(groups, pieces) << begin << " to " << end;
    }
  }
}

TEST(Tracks, AgreeWithSlicesOfNoise) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const double shift : {-0.5, 0.0, 0.55}) {
      SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(shift));
      for (const bool mask : {false, true}) {
        const model::Mesh mesh = woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, mask);
        expectSlicesAgree(mesh);
        expectPiecesAgree(mesh);
      }
    }
  }
}

TEST(Tracks, AgreeWithSlicesOfNoiseWithManyTies) {
  voxel4d::WeaveOptions options;
  options.between = voxel4d::Between::Midpoint;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const double shift : {-0.6, 0.0, 0.6}) {
      SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(shift));
      const model::Mesh mesh = woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, true, options);
      expectSlicesAgree(mesh);
      expectPiecesAgree(mesh);
    }
  }
}

TEST(Tracks, AgreeWithSlicesOfFields) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    SCOPED_TRACE(field.name);
    for (const bool mask : {false, true}) {
      const model::Mesh mesh =
          woven(field.value, field.box, field.timeBegin, field.timeEnd, 7, 1, mask);
      expectSlicesAgree(mesh, 12);
    }
  }
}

TEST(Tracks, OfASweptSolidAreItsComponents) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 170;
  const auto motion = *model::chainScrews(0, {&run, 1});
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    SCOPED_TRACE(solid.name);
    if (solid.mesh.triangles.size() > 3000) continue;
    for (const auto caps : {mesh4d::CapMethod::Cone, mesh4d::CapMethod::TetGen}) {
      model::Mesh mesh;
      ASSERT_TRUE(mesh4d::sweep(solid.mesh, motion, {mesh4d::StepsPerSegment{5}, caps}, mesh));
      const Tracks tracks = tracksIn(mesh);
      EXPECT_TRUE(tracks.events.empty());
      double volume = 0;
      const SolidMeasures whole = measuresOf(solid.mesh);
      EXPECT_EQ(tracks.tracks.size(), whole.components);
      for (const Track& track : tracks.tracks) {
        EXPECT_TRUE(track.beginsWithMesh && track.endsWithMesh);
        ASSERT_EQ(track.samples.size(), 6U);
        for (const TrackSample& sample : track.samples) {
          EXPECT_NEAR(sample.measures.volume, track.samples[0].measures.volume,
                      1e-9 * track.largestVolume);
        }
        volume += track.samples[0].measures.volume;
        EXPECT_EQ(track.samples[0].measures.cavities, whole.cavities / whole.components);
      }
      EXPECT_NEAR(volume, whole.volume, 1e-9 * whole.volume);
    }
  }
}

/// The distance to the surface of a ball, negative inside.
double ball(const Point3& point, const Point3& centre, double radius) {
  return (point - centre).norm() - radius;
}

/// The time of the only event of a kind.
double timeOf(const Tracks& tracks, TrackEventKind kind) {
  double time = -1;
  for (const TrackEvent& event : tracks.events) {
    if (event.kind != kind) continue;
    EXPECT_EQ(time, -1) << "twice";
    time = event.time;
  }
  return time;
}

/// Convergence of the time of an event of a field, to `exact`, of order `order` or better.
void expectConverges(const FieldFunction& field, double size, double end, TrackEventKind kind,
                     double exact) {
  std::vector<double> errors;
  for (const int n : {8, 16, 32}) {
    model::Bounds3 box;
    box.add(Point3::Constant(-size));
    box.add(Point3::Constant(size));
    // Off the symmetry of the lattice.
    const Point3 shift(0.137 / n, 0.211 / n, 0.057 / n);
    const auto shifted = [&](const Point3& point, double time) {
      return field(point + shift, time);
    };
    const model::Mesh mesh = woven(shifted, box, 0, end, n, 2 * size / n / 1.5);
    const Tracks tracks = tracksIn(mesh);
    errors.push_back(std::abs(timeOf(tracks, kind) - exact));
  }
  EXPECT_LT(errors[2], 0.6 * errors[0] + 1e-12)
      << errors[0] << " " << errors[1] << " " << errors[2];
  EXPECT_LT(errors[2], 0.1 * end);
}

TEST(Tracks, FindWhenBallsTouch) {
  // Centres at distance 4 - 3 t, radii 1: they touch at 2/3.
  const auto field = [](const Point3& point, double time) {
    const Point3 half((4 - 3 * time) / 2, 0, 0);
    return std::min(ball(point, half, 1), ball(point, -half, 1));
  };
  expectConverges(field, 3.3, 1, TrackEventKind::Merges, 2.0 / 3);
  const auto apart = [&](const Point3& point, double time) { return field(point, 1 - time); };
  expectConverges(apart, 3.3, 1, TrackEventKind::Splits, 1.0 / 3);
}

TEST(Tracks, FindWhenATorusCloses) {
  // Its tube grows from 0.5 to 1.5, its axis is a circle of radius 1.2.
  const auto field = [](const Point3& point, double time) {
    const double around = std::hypot(point.x(), point.y()) - 1.2;
    return std::hypot(around, point.z()) - (0.5 + time);
  };
  expectConverges(field, 3, 1, TrackEventKind::HoleCloses, 0.7);
}

TEST(Tracks, FindWhenACavityOpens) {
  // A shell, whose cavity moves out of it.
  const auto field = [](const Point3& point, double time) {
    return std::max(ball(point, Point3::Zero(), 2), -ball(point, Point3(1.8 * time, 0, 0), 1));
  };
  expectConverges(field, 3, 1, TrackEventKind::CavityOpens, 1 / 1.8);
  const auto closes = [&](const Point3& point, double time) { return field(point, 1 - time); };
  expectConverges(closes, 3, 1, TrackEventKind::CavityCloses, 1 - 1 / 1.8);
}

TEST(Tracks, FindWhenABallAppearsAndVanishes) {
  const fixtures::Field field = fixtures::pulsatingSphere(6);
  std::vector<double> errors;
  for (const int frames : {12, 48}) {
    const Tracks tracks = tracksIn(
        woven(field.value, field.box, field.timeBegin, field.timeEnd, frames, 12.0 / frames));
    ASSERT_EQ(kindsOf(tracks), (std::vector{TrackEventKind::Appears, TrackEventKind::Vanishes}));
    ASSERT_EQ(tracks.tracks.size(), 1U);
    const Track& track = tracks.tracks[0];
    EXPECT_FALSE(track.beginsWithMesh || track.endsWithMesh);
    EXPECT_EQ(track.begin, tracks.events[0].time);
    EXPECT_EQ(track.end, tracks.events[1].time);
    EXPECT_LT(tracks.events[0].place.norm(), 1);
    errors.push_back(std::abs(track.begin) + std::abs(track.end - 1));
  }
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

TEST(Tracks, TellASolidInACavityFromTheSolidAround) {
  // A ball in a cavity, which grows until it touches the wall.
  const auto field = [](const Point3& point, double time) {
    const double shell = std::max(ball(point, Point3::Zero(), 4), -ball(point, Point3::Zero(), 3));
    return std::min(shell, ball(point, Point3(1, 0.1, 0.2), 0.5 + 2 * time));
  };
  const Tracks tracks = tracksIn(woven(
      field,
      [] {
        model::Bounds3 box;
        box.add(Point3::Constant(-5));
        box.add(Point3::Constant(5));
        return box;
      }(),
      0, 1, 12, 0.5));
  ASSERT_FALSE(tracks.events.empty());
  EXPECT_EQ(tracks.events[0].kind, TrackEventKind::Merges);
  EXPECT_EQ(tracks.tracks.size(), 3U);
  ASSERT_EQ(tracks.events[0].before.size(), 2U);
  ASSERT_EQ(tracks.events[0].after.size(), 1U);
  // The shell has its cavity, the ball has none, what they become has the rest of it.
  EXPECT_EQ(
      tracks.tracks[0].samples[0].measures.cavities + tracks.tracks[1].samples[0].measures.cavities,
      1U);
  EXPECT_EQ(tracks.tracks[2].samples[0].measures.cavities, 1U);
}

TEST(Tracks, OfPolytopesAreOneBall) {
  for (const fixtures::Polytope& polytope : {fixtures::cell16(), fixtures::cell600()}) {
    SCOPED_TRACE(polytope.name);
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = static_cast<std::uint32_t>(polytope.vertices.size());
    connectivity->cells = fixtures::tetrahedra(polytope);
    model::Slab slab;
    slab.vertices = polytope.vertices;
    const auto [low, high] = std::ranges::minmax(
        polytope.vertices, {}, [](const model::Point4& vertex) { return vertex[3]; });
    slab.timeBegin = low[3];
    slab.timeEnd = high[3];
    slab.connectivity = connectivity;
    model::Mesh mesh;
    ASSERT_TRUE(mesh.put(slab));
    const Tracks tracks = tracksIn(mesh);
    EXPECT_EQ(tracks.tracks.size(), 1U);
    EXPECT_TRUE(tracks.events.empty());
    expectSlicesAgree(mesh);
  }
}

TEST(Tracks, DoNotDependOnThreads) {
  const model::Mesh mesh = woven(noiseField(7, 0.1), boxOf(7), 0, 6, 6);
  const auto textOf = [](const Tracks& tracks) {
    std::string text;
    for (const TrackEvent& event : tracks.events) {
      text += std::to_string(event.time) + " " + std::to_string(static_cast<int>(event.kind));
      for (const auto& side : {event.before, event.after}) {
        text += " |";
        for (const std::uint32_t track : side) text += " " + std::to_string(track);
      }
      text += "\n";
    }
    for (const Track& track : tracks.tracks) {
      for (const TrackSample& sample : track.samples) {
        text += std::to_string(sample.measures.volume) + " ";
      }
    }
    return text;
  };
  const std::string all = textOf(tracksIn(mesh));
  const model::ThreadLimit limit(1);
  EXPECT_EQ(textOf(tracksIn(mesh)), all);
  EXPECT_FALSE(all.empty());
}

TEST(Tracks, PrunedOfSpecksAreThoseOfTheSolid) {
  // A ball that splits in two, with noise around.
  const auto field = [](const Point3& point, double time) {
    const Point3 half(1 + 3 * time, 0, 0);
    const double balls = std::min(ball(point, half, 3), ball(point, -half, 3));
    const bool speck = noise(3, point, time * 8) > 0.93 && point.cwiseAbs().maxCoeff() < 7 &&
                       std::abs(point.x()) > 2;
    return speck ? -0.3 : balls;
  };
  model::Bounds3 box;
  box.add(Point3::Constant(-9));
  box.add(Point3::Constant(9));
  const model::Mesh mesh = woven(field, box, 0, 1, 8);
  const Tracks all = tracksIn(mesh);
  EXPECT_GT(all.tracks.size(), 50U);
  EXPECT_EQ(all.prunedTracks, 0U);
  TrackOptions options;
  options.minVolume = 8;
  const Tracks pruned = tracksIn(mesh, options);
  EXPECT_EQ(pruned.tracks.size(), 3U);
  EXPECT_GT(pruned.prunedTracks, 40U);
  const auto isOfTracks = [](const TrackEvent& event) {
    return event.kind <= TrackEventKind::Rearranges;
  };
  EXPECT_EQ(std::ranges::count_if(pruned.events, isOfTracks), 1);
  const double split = timeOf(pruned, TrackEventKind::Splits);
  EXPECT_NEAR(split, 2.0 / 3, 0.15);
  EXPECT_EQ(pruned.tracks[0].into, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(pruned.tracks[1].from, (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(pruned.tracks[0].end, split);
}

}  // namespace
}  // namespace t4d::measure
