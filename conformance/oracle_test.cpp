#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "conformance/backends/own_backends.h"
#include "fixtures/solids.h"
#include "measure/surface_genus.h"
#include "t4d/conformance.h"
#include "t4d/sweep.h"

/// The oracle passes a correct mesh, and detects meshes that were broken on purpose.
namespace t4d::conformance {
namespace {

using model::Cell;
using model::Connectivity;
using model::Point4;
using model::Slab;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;

Case caseOf(const std::string& id) {
  for (Case& given : analyticCases()) {
    if (given.id == id) return given;
  }
  ADD_FAILURE() << id;
  return {};
}

/// The cube on its screw as mesh4d makes it: 24 steps between two caps.
struct Swept {
  Case given = caseOf("cube-screw");
  Expectation expectation = *meshBackend()->expectation(given, {});
  std::vector<Slab> slabs;

  Swept() {
    model::Mesh mesh;
    EXPECT_TRUE(meshBackend()->build(given, {}, mesh));
    slabs.assign(mesh.slabs().begin(), mesh.slabs().end());
  }
  Slab& middle() { return slabs[slabs.size() / 2]; }
};

/// The slab with a connectivity of its own, to be modified.
Connectivity& own(Slab& slab) {
  auto copy = std::make_shared<Connectivity>(*slab.connectivity);
  Connectivity& editable = *copy;
  slab.connectivity = std::move(copy);
  return editable;
}

MeshResult resultOf(const std::vector<Slab>& slabs, const Expectation& expectation) {
  model::Mesh mesh;
  for (const Slab& slab : slabs) EXPECT_TRUE(mesh.put(slab));
  return verify(mesh, expectation);
}

/// The names of the failed checks; those of slices without their time.
std::vector<std::string> failedOf(const MeshResult& result) {
  std::vector<std::string> names;
  for (const Check& check : result.checks) {
    if (check.passed) continue;
    std::string name = check.name;
    if (name.starts_with("slice at ")) name = "slice" + name.substr(name.find(':'));
    if (names.empty() || std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
  }
  return names;
}

std::vector<std::string> failed(const std::vector<Slab>& slabs, const Expectation& expectation) {
  return failedOf(resultOf(slabs, expectation));
}

TEST(Oracle, PassesARightMeshAndSaysByWhat) {
  const Swept swept;
  const MeshResult result = resultOf(swept.slabs, swept.expectation);
  EXPECT_TRUE(result.passed());
  EXPECT_THAT(failedOf(result), IsEmpty());
  EXPECT_GT(result.checks.size(), 40U);
  for (const Check& check : result.checks) EXPECT_NE(check.reason, "") << check.name;
  EXPECT_EQ(result.sliceVolumes.size(), swept.expectation.slices.size());
}

TEST(Oracle, FindsADroppedCell) {
  Swept swept;
  own(swept.middle()).cells.pop_back();
  own(swept.middle()).cellAttributes.clear();
  const MeshResult result = resultOf(swept.slabs, swept.expectation);
  EXPECT_THAT(failedOf(result), IsSupersetOf({"closed", "vertex links", "hypervolume",
                                              "tetrahedra between the caps"}));
  EXPECT_THAT(failedOf(result), Not(Contains("oriented")));
  const auto closed = std::find_if(result.checks.begin(), result.checks.end(),
                                   [](const Check& check) { return check.name == "closed"; });
  EXPECT_THAT(closed->found, testing::HasSubstr("has 1 cells, not 2 (4 such facets)"));
}

TEST(Oracle, FindsAFlippedCell) {
  Swept swept;
  Cell& cell = own(swept.middle()).cells.back();
  std::swap(cell[0], cell[1]);
  const auto names = failed(swept.slabs, swept.expectation);
  EXPECT_THAT(names, IsSupersetOf({"oriented", "hypervolume"}));
  EXPECT_THAT(names, Not(Contains("closed")));
}

TEST(Oracle, FindsAMeshInsideOut) {
  Swept swept;
  std::map<const Connectivity*, std::shared_ptr<const Connectivity>> turned;
  for (Slab& slab : swept.slabs) {
    auto& connectivity = turned[slab.connectivity.get()];
    if (!connectivity) {
      auto copy = std::make_shared<Connectivity>(*slab.connectivity);
      for (Cell& cell : copy->cells) std::swap(cell[2], cell[3]);
      connectivity = copy;
    }
    slab.connectivity = connectivity;
  }
  EXPECT_THAT(failed(swept.slabs, swept.expectation),
              ElementsAre("oriented", "hypervolume", "slice: volume"));
}

TEST(Oracle, FindsAMovedVertex) {
  {  // a centroid: the mesh stays closed, but encloses something else
    Swept swept;
    swept.middle().vertices[swept.middle().connectivity->firstMean()].x() += 0.01;
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Contains("hypervolume"));
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Not(Contains("seams")));
  }
  {  // a vertex of a layer, in one of its two slabs
    Swept swept;
    swept.middle().vertices[0].x() += 1e-9;
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Contains("seams"));
  }
  {  // and in both
    Swept swept;
    Slab& slab = swept.middle();
    Slab& before = swept.slabs[swept.slabs.size() / 2 - 1];
    for (Point4* vertex :
         {&slab.vertices[0], &before.vertices[before.connectivity->firstUpper()]}) {
      vertex->z() += 0.01;
    }
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Contains("hypervolume"));
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Not(Contains("seams")));
  }
  {  // out of all bounds
    Swept swept;
    swept.middle().vertices[swept.middle().connectivity->firstMean()].y() = 1000;
    EXPECT_THAT(failed(swept.slabs, swept.expectation), IsSupersetOf({"largest y", "hypervolume"}));
  }
}

TEST(Oracle, FindsShiftedTimes) {
  const auto shift = [](Slab& slab, double time) {
    slab.timeBegin += time;
    slab.timeEnd += time;
    for (Point4& vertex : slab.vertices) vertex.w() += time;
  };
  {
    Swept swept;
    shift(swept.middle(), 0.01);
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Contains("seams"));
  }
  {
    Swept swept;
    for (Slab& slab : swept.slabs) shift(slab, 0.5);
    EXPECT_THAT(failed(swept.slabs, swept.expectation), IsSupersetOf({"time begin", "time end"}));
    EXPECT_THAT(failed(swept.slabs, swept.expectation), Not(Contains("seams")));
  }
  {  // a vertex off its layer's time
    Swept swept;
    swept.middle().vertices[0].w() += 1e-9;
    EXPECT_THAT(failed(swept.slabs, swept.expectation), ElementsAre("slabs"));
  }
}

TEST(Oracle, FindsDoubledCells) {
  Swept swept;
  Connectivity& connectivity = own(swept.middle());
  connectivity.cellAttributes.clear();
  connectivity.cells.insert(connectivity.cells.end(), connectivity.cells.begin(),
                            connectivity.cells.begin() + 14);
  EXPECT_THAT(failed(swept.slabs, swept.expectation),
              IsSupersetOf({"closed", "vertex links", "tetrahedra between the caps"}));
}

TEST(Oracle, FindsAMissingSlab) {
  Swept swept;
  swept.slabs.erase(swept.slabs.begin() + 5);
  EXPECT_THAT(failed(swept.slabs, swept.expectation), IsSupersetOf({"seams", "hypervolume"}));
  swept = Swept();
  swept.slabs.pop_back();  // the cap
  EXPECT_THAT(failed(swept.slabs, swept.expectation), IsSupersetOf({"closed", "vertex links"}));
}

TEST(Oracle, FindsCellsWithoutVolume) {
  Swept swept;
  Slab& slab = swept.middle();
  // The centroid of a prism moves to that of one of its sides.
  const auto first = slab.connectivity->firstMean();
  const auto last = slab.connectivity->firstUpper() - 1;
  std::uint32_t side = last;
  for (const Cell& cell : slab.connectivity->cells) {
    if (std::find(cell.begin(), cell.end(), last) == cell.end()) continue;
    for (const std::uint32_t vertex : cell) {
      if (vertex >= first && vertex < last) side = vertex;
    }
  }
  slab.vertices[last] = slab.vertices[side];
  EXPECT_THAT(failed(swept.slabs, swept.expectation), Contains("degenerate cells"));
}

TEST(Oracle, StopsAtWhatMakesNoSense) {
  for (const int kind : {0, 1}) {
    Swept swept;
    if (kind == 0) own(swept.middle()).cells[0][0] = 1'000'000;
    if (kind == 1) swept.middle().vertices[3].x() = std::numeric_limits<double>::quiet_NaN();
    const MeshResult result = resultOf(swept.slabs, swept.expectation);
    EXPECT_THAT(failedOf(result), ElementsAre("slabs"));
    EXPECT_EQ(result.checks.size(), 1U);
    EXPECT_THAT(result.checks[0].found, testing::HasSubstr("slab 13: "));
  }
}

/// The boundary of the 4-simplex of these vertices.
void addPentachoron(Connectivity& connectivity, std::uint32_t corner,
                    const std::array<std::uint32_t, 4>& others) {
  const std::array<std::uint32_t, 5> vertices = {corner, others[0], others[1], others[2],
                                                 others[3]};
  for (std::uint32_t opposite = 0; opposite < 5; ++opposite) {
    Cell cell{};
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < 5; ++v) {
      if (v != opposite) cell[count++] = vertices[v];
    }
    if (opposite % 2 != 0) std::swap(cell[0], cell[1]);
    connectivity.cells.push_back(cell);
  }
}

TEST(Oracle, FindsMeshesThatTouchInAVertex) {
  Slab slab;
  slab.timeBegin = -1;
  slab.timeEnd = 1;
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 9;
  slab.vertices.push_back(Point4::Zero());
  for (int i = 0; i < 4; ++i) slab.vertices.push_back(Point4::Unit(i));
  for (int i = 0; i < 4; ++i) slab.vertices.push_back(-Point4::Unit(i));
  addPentachoron(*connectivity, 0, {1, 2, 3, 4});
  addPentachoron(*connectivity, 0, {5, 6, 7, 8});  // four axes turned: the same orientation
  slab.connectivity = connectivity;
  Expectation expectation;
  expectation.timeBegin = {-1, 0, "given"};
  expectation.timeEnd = {1, 0, "given"};
  expectation.hypervolume = Measure{2.0 / 24, 1e-15, "two simplices"};
  EXPECT_THAT(failed({slab}, expectation), ElementsAre("vertex links"));
}

TEST(Oracle, TellsTopologiesApart) {
  const auto swept = [](const model::TriangleMesh& mesh) {
    model::Mesh made;
    const model::ScrewRun run{1, {}, 1};
    EXPECT_TRUE(mesh4d::sweep(mesh, *model::chainScrews(0, std::span(&run, 1)),
                              {.caps = mesh4d::CapMethod::Cone}, made));
    return made;
  };
  const auto expectationOf = [](std::vector<int> genera) {
    Expectation expectation;
    expectation.timeBegin = {0, 0, "given"};
    expectation.timeEnd = {1, 0, "given"};
    expectation.slices.push_back({0.5, {}, {}, std::move(genera)});
    expectation.manifoldCaps = false;
    return expectation;
  };
  model::Mesh ball = swept(fixtures::icosphere(3, 1));
  model::Mesh torus = swept(fixtures::torus(3, 1, 9, 5));
  model::Mesh hollow = swept(fixtures::hollowCube(4, 2));
  EXPECT_TRUE(verify(ball, expectationOf({0})).passed());
  EXPECT_TRUE(verify(torus, expectationOf({1})).passed());
  EXPECT_TRUE(verify(hollow, expectationOf({0, 0})).passed());
  EXPECT_THAT(failedOf(verify(torus, expectationOf({0}))), ElementsAre("slice: genus"));
  EXPECT_THAT(failedOf(verify(ball, expectationOf({1}))), ElementsAre("slice: genus"));
  EXPECT_THAT(failedOf(verify(hollow, expectationOf({0}))), ElementsAre("slice: surfaces"));
  EXPECT_THAT(failedOf(verify(ball, expectationOf({0, 0}))), ElementsAre("slice: surfaces"));
  EXPECT_THAT(failedOf(verify(ball, expectationOf({}))), ElementsAre("slice: surfaces"));
  // A cone over a torus: the mesh is not a manifold at its apex.
  Expectation strict = expectationOf({1});
  strict.manifoldCaps = true;
  EXPECT_THAT(failedOf(verify(torus, strict)), ElementsAre("vertex links inside the caps"));
}

TEST(Oracle, FindsTheSameSolidElsewhere) {
  // A cube that rotates the other way has the same volumes and fills the same box.
  Case given = caseOf("cube-about-z");
  const Expectation expectation = *meshBackend()->expectation(given, {});
  given.mesh->motion.segments[0].screw.angleDegrees *= -1;
  model::Segment& segment = given.mesh->motion.segments[0];
  segment.end = segment.screw.at(1);
  model::Mesh mesh;
  ASSERT_TRUE(meshBackend()->build(given, {}, mesh));
  EXPECT_THAT(failedOf(verify(mesh, expectation)),
              ElementsAre("slice: farthest vertex from the true surface",
                          "first contact with the obstacle"));
}

TEST(Oracle, ComparesWithinTheTolerance) {
  const Measure measure{2, 0.5, "because"};
  EXPECT_TRUE(measureIs("m", measure, 2.5).passed);
  EXPECT_FALSE(measureIs("m", measure, 2.5 + 1e-12).passed);
  EXPECT_FALSE(measureIs("m", measure, std::numeric_limits<double>::quiet_NaN()).passed);
  EXPECT_FALSE(countIs("c", 3, 4, "because").passed);
  EXPECT_FALSE(holds("h", true, false, "because").passed);
}

TEST(SurfaceGenus, IsThatOfEachSurface) {
  EXPECT_THAT(measure::generaOf({}), IsEmpty());
  EXPECT_THAT(measure::generaOf(fixtures::cube(1)), ElementsAre(0));
  EXPECT_THAT(measure::generaOf(fixtures::torus(3, 1, 8, 5)), ElementsAre(1));
  EXPECT_THAT(measure::generaOf(fixtures::hollowCube(2, 1)), ElementsAre(0, 0));
  model::TriangleMesh both = fixtures::cube(1);
  const auto first = static_cast<std::uint32_t>(both.vertices.size());
  const model::TriangleMesh torus = fixtures::torus(3, 1, 8, 5);
  both.vertices.insert(both.vertices.end(), torus.vertices.begin(), torus.vertices.end());
  both.vertices.emplace_back(9, 9, 9);  // in no triangle
  for (const auto& [a, b, c] : torus.triangles) {
    both.triangles.push_back({first + a, first + b, first + c});
  }
  EXPECT_THAT(measure::generaOf(both), ElementsAre(1, 0));
  // Joined at one vertex they are a single surface that is not a manifold: half a handle is
  // missing.
  for (auto& triangle : both.triangles) {
    for (auto& vertex : triangle) {
      if (vertex == first) vertex = 0;
    }
  }
  EXPECT_THAT(measure::generaOf(both), ElementsAre(0.5));
}

}  // namespace
}  // namespace t4d::conformance
