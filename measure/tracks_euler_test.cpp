#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/polytopes.h"
#include "fixtures/solids.h"
#include "measure/surface_genus.h"
#include "measure/woven_noise.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

/// Euler's formula in the order of time.
namespace t4d::measure {
namespace {

/// The index of each vertex, by its time: 1 less the Euler number of its lower link, which has a
/// simplex for each edge, triangle and tetrahedron that ends at the vertex. It is 0 of a regular
/// vertex. Vertices of one time come in any order.
std::multimap<double, std::int64_t> indicesOf(const model::Mesh& mesh) {
  const auto flat = model::flatten(mesh);
  EXPECT_TRUE(flat) << flat.error().text();
  if (!flat) return {};
  const auto timeOf = [&](std::uint32_t v) { return flat->vertices(v, 3); };
  std::vector<std::vector<std::uint32_t>> simplices;
  for (const auto& cell : flat->cells.rowwise()) {
    std::vector<std::uint32_t> corners(cell.begin(), cell.end());
    std::ranges::sort(corners, {}, [&](std::uint32_t v) { return std::pair(timeOf(v), v); });
    for (unsigned some = 1; some < 16; ++some) {
      std::vector<std::uint32_t> simplex;
      for (unsigned i = 0; i < 4; ++i) {
        if ((some >> i & 1U) != 0) simplex.push_back(corners[i]);
      }
      if (simplex.size() > 1) simplices.push_back(std::move(simplex));
    }
  }
  std::ranges::sort(simplices);
  simplices.erase(std::unique(simplices.begin(), simplices.end()), simplices.end());
  std::vector<std::int64_t> index(static_cast<std::size_t>(flat->vertices.rows()), 1);
  for (const auto& simplex : simplices) index[simplex.back()] -= simplex.size() % 2 == 0 ? 1 : -1;
  std::multimap<double, std::int64_t> byTime;
  for (std::uint32_t v = 0; v < index.size(); ++v) byTime.emplace(timeOf(v), index[v]);
  return byTime;
}

std::int64_t eulerAt(const model::Mesh& mesh, double time) {
  const auto slice = slice::sliceAtTime(mesh, time);
  EXPECT_TRUE(slice);
  double euler = 0;
  for (const ConnectedSurface& surface : surfacesOf(slice->mesh)) euler += 2 - 2 * surface.genus;
  return std::llround(euler);
}

/// The alternating sum of critical vertices is 0, and between any two times the Euler number of the
/// slice changes by twice the indices of the vertices and by the events there.
void expectEulersFormula(const model::Mesh& mesh, std::size_t most = 25) {
  const auto indices = indicesOf(mesh);
  std::int64_t sum = 0;
  std::set<double> times;
  for (const auto& [time, index] : indices) {
    sum += index;
    times.insert(time);
  }
  EXPECT_EQ(sum, 0);
  const auto tracks = tracksOf(mesh, {.times = {}, .layers = false});
  ASSERT_TRUE(tracks);
  const std::vector<double> sorted(times.begin(), times.end());
  const std::size_t every = std::max<std::size_t>(1, sorted.size() / most);
  double last = 0;
  std::int64_t before = 0;
  for (std::size_t i = 0; i + 1 < sorted.size(); i += every) {
    const double time = sorted[i] + (sorted[i + 1] - sorted[i]) / 2;
    if (time <= sorted[i] || time >= sorted[i + 1]) continue;
    const std::int64_t now = eulerAt(mesh, time);
    if (i > 0) {
      std::int64_t ofVertices = 0;
      for (auto at = indices.upper_bound(last); at != indices.end() && at->first < time; ++at) {
        ofVertices += 2 * at->second;
      }
      std::int64_t ofEvents = 0;
      for (const TrackEvent& event : tracks->events) {
        if (event.time > last && event.time < time) ofEvents += event.euler;
      }
      EXPECT_EQ(now - before, ofVertices) << last << " to " << time;
      EXPECT_EQ(now - before, ofEvents) << last << " to " << time;
    }
    last = time;
    before = now;
  }
}

TEST(TracksEuler, HoldsForNoise) {
  voxel4d::WeaveOptions midpoints;
  midpoints.between = voxel4d::Between::Midpoint;
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    for (const double shift : {-0.5, 0.0, 0.5}) {
      SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(shift));
      expectEulersFormula(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4));
      expectEulersFormula(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, true));
      expectEulersFormula(woven(noiseField(seed, shift), boxOf(5), 0, 4, 4, 1, true, midpoints));
    }
  }
}

TEST(TracksEuler, HoldsForFields) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    SCOPED_TRACE(field.name);
    for (const bool mask : {false, true}) {
      expectEulersFormula(woven(field.value, field.box, field.timeBegin, field.timeEnd, 6, 1, mask),
                          12);
    }
  }
}

TEST(TracksEuler, HoldsForSweptSolids) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 170;
  const auto motion = *model::chainScrews(0, {&run, 1});
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    if (solid.mesh.triangles.size() > 3000) continue;
    SCOPED_TRACE(solid.name);
    model::Mesh mesh;
    ASSERT_TRUE(mesh4d::sweep(solid.mesh, motion,
                              {mesh4d::StepsPerSegment{3}, mesh4d::CapMethod::TetGen}, mesh));
    expectEulersFormula(mesh, 6);
  }
}

void expectEulersFormula(const fixtures::Polytope& polytope) {
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
  expectEulersFormula(mesh);
}

/// The formula also holds where all vertices have times of their own.
TEST(TracksEuler, HoldsForPolytopes) {
  for (fixtures::Polytope& polytope : fixtures::polytopes()) {
    expectEulersFormula(polytope);
    for (model::Point4& vertex : polytope.vertices) {
      vertex[3] = vertex.dot(model::Point4(0.311, 0.523, 0.642, 0.468));
    }
    expectEulersFormula(polytope);
  }
}

}  // namespace
}  // namespace t4d::measure
