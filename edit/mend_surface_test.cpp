#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "edit/remesh_surface.h"
#include "edit/surface_crossings.h"
#include "fixtures/damaged.h"
#include "fixtures/solids.h"
#include "model/surface_check.h"
#include "t4d/edit.h"
#include "t4d/surface.h"
#include "tests/paths.h"

namespace t4d::edit {
namespace {

using fixtures::translated;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;
using testing::ElementsAre;

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
}

TriangleMesh both(TriangleMesh mesh, const TriangleMesh& other) {
  append(mesh, other);
  return mesh;
}

TriangleMesh insideOut(TriangleMesh mesh) {
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  return mesh;
}

/// Every triangle with corners of its own, as in an STL file.
TriangleMesh soupOf(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Triangle& triangle : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t corner : triangle) soup.vertices.push_back(mesh.vertices[corner]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// What a file keeps of a mesh: equal vertices are one.
TriangleMesh merged(const TriangleMesh& mesh) {
  TriangleMesh result;
  std::map<std::array<double, 3>, std::uint32_t> numbers;
  std::vector<std::uint32_t> numberOf;
  for (const Point3& p : mesh.vertices) {
    const auto [at, isNew] = numbers.try_emplace(
        {p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(result.vertices.size()));
    if (isNew) result.vertices.push_back(p);
    numberOf.push_back(at->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    result.triangles.push_back({numberOf[a], numberOf[b], numberOf[c]});
  }
  return result;
}

testing::AssertionResult boundsASolid(const TriangleMesh& mesh) {
  const TriangleMesh kept = merged(mesh);
  if (auto closed = model::checkClosedSurface(kept); !closed) {
    return testing::AssertionFailure() << closed.error().text();
  }
  const auto crossings = findCrossings(kept, 1);
  if (!crossings) return testing::AssertionFailure() << crossings.error().text();
  if (!crossings->flat.empty()) return testing::AssertionFailure() << "a flat triangle";
  if (!crossings->pairs.empty()) return testing::AssertionFailure() << "a crossing";
  if (!(signedVolume(mesh) > 0)) return testing::AssertionFailure() << "not outward";
  return testing::AssertionSuccess();
}

/// The kinds of changes in their order; the mesh becomes the mended one, which bounds a solid.
std::vector<std::string> mended(TriangleMesh& mesh, const MendSurfaceOptions& options = {}) {
  const auto report = mendSurface(mesh, options);
  if (!report) {
    ADD_FAILURE() << report.error().text();
    return {};
  }
  EXPECT_TRUE(boundsASolid(mesh));
  EXPECT_TRUE(report->closed && report->manifold && report->selfIntersections == 0U);
  EXPECT_EQ(report->volumeAfter, signedVolume(mesh));
  std::vector<std::string> kinds;
  for (const SurfaceChange& change : report->changes) {
    EXPECT_GT(change.count, 0U);
    EXPECT_NE(change.text, "");
    kinds.emplace_back(nameOf(change.kind));
  }
  return kinds;
}

Remedy remedyOf(const TriangleMesh& given, const MendSurfaceOptions& options) {
  TriangleMesh mesh = given;
  const auto report = mendSurface(mesh, options);
  EXPECT_FALSE(report);
  EXPECT_EQ(mesh.triangles, given.triangles);
  return report ? Remedy::None : report.error().remedy;
}

TEST(MendSurface, MendsAtAnySizeAsAtSizeOne) {
  const std::array<TriangleMesh, 4> damaged = {
      insideOut(fixtures::torus(3, 1, 12, 8)),
      both(fixtures::cube(2), translated(fixtures::cube(2), {0.5, 0.3, 0.7})),
      both(fixtures::cube(4), fixtures::cube(2)), [] {
        TriangleMesh open = fixtures::torus(3, 1, 12, 8);
        open.triangles.erase(open.triangles.begin() + 7, open.triangles.begin() + 11);
        return open;
      }()};
  for (const TriangleMesh& given : damaged) {
    TriangleMesh expected = given;
    const auto wanted = mendSurface(expected);
    ASSERT_TRUE(wanted) << wanted.error().text();
    for (const int exponent : {-465, -190, -100, 100, 180, 465}) {
      const double scale = std::ldexp(1.0, exponent);
      TriangleMesh mesh = given;
      for (Point3& vertex : mesh.vertices) vertex *= scale;
      const auto report = mendSurface(mesh);
      ASSERT_TRUE(report) << report.error().text();
      ASSERT_EQ(mesh.triangles, expected.triangles) << exponent;
      for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        EXPECT_EQ(mesh.vertices[i], expected.vertices[i] * scale);
      }
      ASSERT_EQ(report->changes.size(), wanted->changes.size());
      EXPECT_EQ(report->hausdorff, wanted->hausdorff * scale);
      EXPECT_EQ(report->volumeAfter, std::ldexp(wanted->volumeAfter, 3 * exponent));
    }
  }
}

TEST(MendSurface, ChangesNothingInASolid) {
  for (const auto& solid : fixtures::allSolids()) {
    TriangleMesh mesh = solid.mesh;
    const auto report = mendSurface(mesh);
    ASSERT_TRUE(report) << solid.name << report.error().text();
    EXPECT_TRUE(report->changes.empty()) << solid.name;
    EXPECT_EQ(report->hausdorff, 0);
    EXPECT_EQ(report->volumeBefore, report->volumeAfter);
    EXPECT_EQ(mesh.triangles, solid.mesh.triangles);
    EXPECT_EQ(mesh.vertices, solid.mesh.vertices);
  }
}

TEST(MendSurface, MergesTheVerticesOfASoup) {
  TriangleMesh mesh = soupOf(fixtures::icosphere(1, 2));
  EXPECT_THAT(mended(mesh), ElementsAre("doubled"));
  EXPECT_EQ(mesh.vertices.size(), fixtures::icosphere(1, 2).vertices.size());
}

TEST(MendSurface, MergesVerticesWithinADistance) {
  TriangleMesh mesh = soupOf(fixtures::icosphere(1, 2));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  for (Point3& vertex : mesh.vertices) vertex += Point3(noise(random), noise(random), 0);
  EXPECT_THAT(mended(mesh, {.weld = 1e-5}), ElementsAre("doubled"));
  EXPECT_EQ(mesh.vertices.size(), fixtures::icosphere(1, 2).vertices.size());
}

TEST(MendSurface, DropsDuplicatesAndDegenerateTriangles) {
  const TriangleMesh cube = fixtures::cube(2);
  TriangleMesh mesh = cube;
  mesh.triangles.push_back(cube.triangles[3]);
  const auto [a, b, c] = cube.triangles[5];
  mesh.triangles.push_back({c, b, a});
  mesh.triangles.push_back({a, a, b});
  EXPECT_THAT(mended(mesh), ElementsAre("duplicate", "duplicate"));
  EXPECT_EQ(mesh.triangles, cube.triangles);
}

TEST(MendSurface, DropsFinsAndWalls) {
  const TriangleMesh cube = fixtures::cube(2);
  TriangleMesh fin = cube;
  fin.vertices.emplace_back(3, 3, 3);
  fin.triangles.push_back({cube.triangles[0][0], cube.triangles[0][1], 8});
  TriangleMesh counted = fin;
  EXPECT_EQ(mendSurface(counted)->changes.at(0).count, 1U);
  EXPECT_THAT(mended(fin), ElementsAre("stray"));
  EXPECT_EQ(fin.triangles, cube.triangles);
  // A wall between the halves of a bipyramid.
  const TriangleMesh bipyramid = fixtures::bipyramid(6);
  TriangleMesh wall = bipyramid;
  std::vector<std::uint32_t> rim;
  for (std::uint32_t i = 0; i < wall.vertices.size(); ++i) {
    if (wall.vertices[i].z() == 0) rim.push_back(i);
  }
  ASSERT_EQ(rim.size(), 6U);
  for (std::uint32_t i = 1; i + 1 < 6; ++i) wall.triangles.push_back({rim[0], rim[i], rim[i + 1]});
  counted = wall;
  EXPECT_EQ(mendSurface(counted)->changes.at(0).count, 4U);
  EXPECT_THAT(mended(wall), ElementsAre("stray"));
  EXPECT_EQ(wall.triangles, bipyramid.triangles);
}

TEST(MendSurface, TurnsTrianglesThatDisagree) {
  const TriangleMesh ball = fixtures::icosphere(1, 2);
  TriangleMesh mesh = ball;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  }
  EXPECT_THAT(mended(mesh), ElementsAre("turned"));
  EXPECT_EQ(mesh.triangles, ball.triangles);
  TriangleMesh inverted = insideOut(ball);
  EXPECT_THAT(mended(inverted), ElementsAre("inside-out"));
}

TEST(MendSurface, KeepsCavitiesAndTurnsComponentsThatAreNone) {
  TriangleMesh hollow = insideOut(fixtures::hollowCube(4, 2));
  EXPECT_THAT(mended(hollow), ElementsAre("inside-out"));
  EXPECT_NEAR(signedVolume(hollow), 64 - 8, 1e-12);
  TriangleMesh beside =
      both(fixtures::cube(4), translated(insideOut(fixtures::cube(2)), {5, 0, 0}));
  EXPECT_THAT(mended(beside), ElementsAre("inside-out"));
  EXPECT_NEAR(signedVolume(beside), 64 + 8, 1e-12);
  // The cavity is one of the shell that is turned, in whichever order they come.
  const TriangleMesh large = fixtures::cube(6);
  const TriangleMesh shell = translated(insideOut(fixtures::cube(4)), {8, 0, 0});
  const TriangleMesh cavity = translated(insideOut(fixtures::cube(2)), {8, 0, 0});
  for (TriangleMesh mesh : {both(both(large, shell), cavity), both(both(cavity, shell), large)}) {
    EXPECT_THAT(mended(mesh), ElementsAre("inside-out"));
    EXPECT_NEAR(signedVolume(mesh), 216 + 64 - 8, 1e-12);
  }
  // A solid within a solid adds nothing.
  TriangleMesh nested = both(fixtures::cube(4), fixtures::cube(2));
  EXPECT_THAT(mended(nested), ElementsAre("crossing"));
  EXPECT_EQ(nested.triangles.size(), 12U);
}

TEST(MendSurface, FillsFlatHolesExactly) {
  TriangleMesh mesh = fixtures::paperCube(2);
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return std::ranges::all_of(triangle, [&](auto i) { return mesh.vertices[i].z() == 1; });
  });
  TriangleMesh given = mesh;
  EXPECT_THAT(mended(mesh, {.maxHole = 3}), ElementsAre("hole"));
  EXPECT_NEAR(signedVolume(mesh), 8, 1e-12);
  EXPECT_EQ(remedyOf(given, {.maxHole = 2.8}), Remedy::MaxHole);  // it is 2 sqrt 2 wide
}

TEST(MendSurface, FillsTheHoleOfABallUpToItsCap) {
  const TriangleMesh ball = fixtures::icosphere(1, 4);
  TriangleMesh mesh = ball;
  std::erase_if(mesh.triangles,
                [&](const Triangle& triangle) { return mesh.vertices[triangle[0]].z() > 0.9; });
  EXPECT_THAT(mended(mesh), ElementsAre("hole"));
  // The cap of height h that is gone has the volume pi h^2 (1 - h / 3); the rim is ragged.
  EXPECT_NEAR(signedVolume(mesh), signedVolume(ball) - std::numbers::pi * 0.01, 0.015);
}

TEST(MendSurface, FillsASheetToTheSolidThatItBends) {
  // Half of a tube along z: its flat ends and side are missing. A surface through the rim that
  // folds back onto the sheet would enclose nothing.
  constexpr std::uint32_t kSides = 20;
  constexpr std::uint32_t kRings = 8;
  TriangleMesh mesh;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring) {
    for (std::uint32_t side = 0; side <= kSides; ++side) {
      const double angle = std::numbers::pi * side / kSides;
      mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.25 * ring);
      if (ring == 0 || side == 0) continue;
      const auto d = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
      const std::uint32_t b = d - kSides - 1;
      mesh.triangles.push_back({b - 1, b, d});
      mesh.triangles.push_back({b - 1, d, d - 1});
    }
  }
  mended(mesh);
  const double half = 0.5 * kSides * std::sin(std::numbers::pi / kSides);
  EXPECT_NEAR(signedVolume(mesh), 0.25 * kRings * half, 1e-3);
}

TEST(MendSurface, FillsHolesThatTouchAtAVertex) {
  TriangleMesh mesh = fixtures::icosphere(1, 3);
  const double volume = signedVolume(mesh);
  // The mesh loses every second triangle around the first vertex.
  std::uint32_t found = 0;
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return std::ranges::count(triangle, 0U) > 0 && ++found % 2 == 0;
  });
  EXPECT_THAT(mended(mesh), ElementsAre("hole"));
  EXPECT_NEAR(signedVolume(mesh), volume, 1e-12);
}

TEST(MendSurface, TakesTheUnionOfCubes) {
  // One corner inside the other: nothing but rounding.
  TriangleMesh corner = both(fixtures::cube(2), translated(fixtures::cube(2), {0.7, 0.8, 0.9}));
  EXPECT_THAT(mended(corner), ElementsAre("crossing"));
  EXPECT_NEAR(signedVolume(corner), 16 - 1.3 * 1.2 * 1.1, 1e-12);
  // Coplanar sides, with other diagonals.
  TriangleMesh coplanar = both(fixtures::cube(2), translated(fixtures::cube(2), {1, 0, 0}));
  EXPECT_THAT(mended(coplanar), ElementsAre("crossing"));
  EXPECT_NEAR(signedVolume(coplanar), 12, 1e-12);
  // The cubes share a side.
  TriangleMesh side = both(fixtures::cube(2), translated(fixtures::cube(2), {2, 0, 0}));
  mended(side);
  EXPECT_NEAR(signedVolume(side), 16, 1e-12);
  // A part of a side.
  TriangleMesh part = both(fixtures::cube(2), translated(fixtures::cube(1), {1.5, 0.25, 0}));
  EXPECT_THAT(mended(part), ElementsAre("crossing"));
  EXPECT_NEAR(signedVolume(part), 9, 1e-12);
  // Coplanar sides whose edges cross in their plane, across each axis.
  for (int axis = 0; axis < 3; ++axis) {
    Point3 half = Point3::Constant(0.5);
    Point3 at = Point3::Constant(0.25);
    half[axis] = half[(axis + 1) % 3] = 1.5;
    at[axis] = 0.5;
    at[(axis + 1) % 3] = 1.5;
    TriangleMesh box = fixtures::cube(2);
    for (Point3& vertex : box.vertices) vertex = vertex.cwiseProduct(half) + at;
    TriangleMesh crossed = both(fixtures::cube(2), box);
    EXPECT_THAT(mended(crossed), ElementsAre("crossing"));
    EXPECT_NEAR(signedVolume(crossed), 8 + 9 - 2, 1e-12) << axis;
  }
  // The same cube again, and three along the diagonal.
  TriangleMesh row = fixtures::cube(2);
  append(row, translated(fixtures::cube(2), {0, 0, 0}));
  append(row, translated(fixtures::cube(2), {1, 1, 1}));
  append(row, translated(fixtures::cube(2), {2, 2, 2}));
  mended(row);
  EXPECT_NEAR(signedVolume(row), 24 - 2, 1e-4);
}

TEST(MendSurface, TakesTheUnionOfBalls) {
  const TriangleMesh ball = fixtures::icosphere(1, 4);
  TriangleMesh mesh = both(ball, translated(ball, {1.1, 0.013, 0.007}));
  EXPECT_THAT(mended(mesh), ElementsAre("crossing"));
  // The lens between balls of radius 1 at distance d has the volume pi (4 + d) (2 - d)^2 / 12.
  const double d = std::sqrt(1.1 * 1.1 + 0.013 * 0.013 + 0.007 * 0.007);
  const double lens = std::numbers::pi * (4 + d) * (2 - d) * (2 - d) / 12;
  EXPECT_NEAR(signedVolume(mesh), 8 * std::numbers::pi / 3 - lens, 0.04);
}

TEST(MendSurface, CutsAwayWhatPierces) {
  // A corner of a cube pushed through the side opposite.
  TriangleMesh mesh = fixtures::icosphere(1, 3);
  const double volume = signedVolume(mesh);
  mesh.vertices[0] = Point3(-1.5 * mesh.vertices[0]);
  mended(mesh);
  EXPECT_LT(signedVolume(mesh), volume);
}

TEST(MendSurface, TakesApartWhatTouches) {
  // The cubes share a vertex, then an edge.
  TriangleMesh vertex = both(fixtures::cube(2), translated(fixtures::cube(2), {2, 2, 2}));
  EXPECT_THAT(mended(vertex), ElementsAre("doubled", "non-manifold"));
  EXPECT_NEAR(signedVolume(vertex), 16, 1e-3);
  TriangleMesh edge = both(fixtures::cube(2), translated(fixtures::cube(2), {2, 2, 0}));
  EXPECT_THAT(mended(edge), ElementsAre("doubled", "non-manifold"));
  EXPECT_NEAR(signedVolume(edge), 16, 1e-3);
  TriangleMesh part = both(fixtures::cube(2), translated(fixtures::cube(2), {2, 2, 0.5}));
  EXPECT_THAT(mended(part), ElementsAre("crossing", "non-manifold"));
  EXPECT_NEAR(signedVolume(part), 16, 1e-3);
}

TEST(MendSurface, TakesManyCavitiesFromTheSurfaceThatTheyTouch) {
  // A cavity has to move the other way than its solid.
  TriangleMesh one = fixtures::paperCube(4);
  append(one, insideOut(translated(fixtures::bipyramid(4), {0, 0, 1})));
  TriangleMesh row;
  constexpr int kCubes = 40;
  for (int i = 0; i < kCubes; ++i) append(row, translated(one, {5.0 * i, 0, 0}));
  EXPECT_THAT(mended(row), ElementsAre("doubled", "non-manifold"));
  EXPECT_NEAR(signedVolume(row), kCubes * (64 - 4.0 / 3), 1);
}

TEST(MendSurface, DividesTrianglesAtVerticesOnTheirEdges) {
  // One triangle of a cube divided on a side that its neighbour does not divide.
  TriangleMesh mesh = fixtures::cube(2);
  const auto [a, b, c] = mesh.triangles[0];
  mesh.vertices.emplace_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
  mesh.triangles[0] = {a, 8, c};
  mesh.triangles.push_back({8, b, c});
  mended(mesh);
  EXPECT_NEAR(signedVolume(mesh), 8, 1e-12);
  EXPECT_EQ(mesh.triangles.size(), 14U);
}

TEST(MendSurface, RefusesToMoveFartherThanAllowed) {
  TriangleMesh mesh = fixtures::icosphere(1, 3);
  std::erase_if(mesh.triangles,
                [&](const Triangle& triangle) { return mesh.vertices[triangle[0]].z() > 0.9; });
  EXPECT_EQ(remedyOf(mesh, {.maxMove = 0.01}), Remedy::MaxMove);
  EXPECT_THAT(mended(mesh, {.maxMove = 1}), ElementsAre("hole"));
}

TEST(MendSurface, RemeshesOnlyWhenNothingElseHelps) {
  TriangleMesh mesh = both(fixtures::cube(2), translated(fixtures::cube(2), {0.7, 0.8, 0.9}));
  EXPECT_THAT(mended(mesh, {.remesh = 0.1}), ElementsAre("crossing"));
  // A Moebius strip has only one side; it bounds nothing, but stands in a cube here.
  TriangleMesh strip;
  constexpr std::uint32_t kSteps = 24;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps;
    for (const double s : {-0.2, 0.2}) {
      const double radius = 0.6 + s * std::cos(angle / 2);
      strip.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                  s * std::sin(angle / 2));
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    std::uint32_t c = 2 * i + 2;
    std::uint32_t d = 2 * i + 3;
    if (i + 1 == kSteps) c = 1, d = 0;
    strip.triangles.push_back({2 * i, 2 * i + 1, c});
    strip.triangles.push_back({2 * i + 1, d, c});
  }
  TriangleMesh twisted = both(fixtures::cube(2), strip);
  EXPECT_EQ(remedyOf(twisted, {}), Remedy::Remesh);
  EXPECT_THAT(mended(twisted, {.remesh = 0.1}), ElementsAre("remeshed"));
  EXPECT_NEAR(signedVolume(twisted), 8, 0.3);
}

TEST(MendSurface, UnitesSolidsWhoseNormalsVanishInDoubles) {
  TriangleMesh mesh = translated(fixtures::cube(1), {2, 2, 2});
  for (const double shift : {0.0, 1e-170}) {
    append(mesh, translated(fixtures::cube(2e-170), {shift, shift, shift}));
  }
  EXPECT_THAT(mended(mesh), ElementsAre("crossing"));
  EXPECT_EQ(signedVolume(mesh), 1);
}

TEST(RemeshSurface, IsOfSecondOrderOnABall) {
  double last = 0;
  for (const double size : {0.1, 0.05}) {
    const auto mesh = remeshSurface(fixtures::icosphere(1, 5), size);
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_TRUE(boundsASolid(*mesh));
    const double error = std::abs(signedVolume(*mesh) - 4 * std::numbers::pi / 3);
    if (last > 0) {
      EXPECT_LT(error, last / 2.5);
    }
    last = error;
  }
}

TEST(RemeshSurface, ClosesHolesAndJoinsOverlaps) {
  TriangleMesh open = fixtures::icosphere(1, 3);
  std::erase_if(open.triangles,
                [&](const Triangle& triangle) { return open.vertices[triangle[0]].z() > 0.9; });
  append(open, translated(fixtures::icosphere(1, 3), {1.1, 0, 0}));
  const auto mesh = remeshSurface(open, 0.05);
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_TRUE(boundsASolid(*mesh));
  const double lens = std::numbers::pi * 5.1 * 0.81 / 12;
  EXPECT_NEAR(signedVolume(*mesh), 8 * std::numbers::pi / 3 - lens, 0.25);
}

TEST(RemeshSurface, RefusesVoxelsThatAreTooSmallOrTooLarge) {
  const auto small = remeshSurface(fixtures::cube(2), 1e-5);
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().remedy, Remedy::RemeshSize);
  EXPECT_THAT(small.error().message, testing::HasSubstr("a size of 0.00"));
  for (const double size : {50.0, 0.0, 1e31}) {
    const auto wrong = remeshSurface(fixtures::cube(2), size);
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().remedy, Remedy::RemeshSize);
  }
}

TEST(MendSurface, MendsAnyDamageOrSaysWhyNot) {
  const std::vector<TriangleMesh> solids = {fixtures::icosphere(1, 2),
                                            fixtures::torus(1, 0.4, 16, 8),
                                            fixtures::hollowCube(2, 1), fixtures::pebble(1, 120)};
  int refused = 0;
  constexpr int kSeeds = 120;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](std::size_t n) {
      return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    std::uniform_real_distribution<double> shift(-0.7, 0.7);
    TriangleMesh mesh = solids[below(solids.size())];
    if (below(2) == 0) {
      append(mesh, translated(solids[below(solids.size())],
                              {shift(random), shift(random), shift(random)}));
    }
    for (std::size_t damages = 1 + below(8); damages > 0; --damages) {
      Triangle& triangle = mesh.triangles[below(mesh.triangles.size())];
      const auto other = static_cast<std::uint32_t>(below(mesh.vertices.size()));
      switch (below(7)) {
        case 0:  // a hole
          triangle = mesh.triangles.back();
          mesh.triangles.pop_back();
          break;
        case 1:
          std::swap(triangle[0], triangle[1]);
          break;
        case 2:
          mesh.triangles.push_back(Triangle(triangle));
          break;
        case 3:
          mesh.triangles.push_back({triangle[0], triangle[1], other});
          break;
        case 4:  // a fold
          mesh.vertices[other] += Point3(shift(random), shift(random), shift(random));
          break;
        case 5:  // two vertices at one place
          mesh.vertices[other] = Point3(mesh.vertices[triangle[0]]);
          break;
        default:
          mesh = soupOf(mesh);
      }
    }
    const TriangleMesh given = mesh;
    auto report = mendSurface(mesh);
    if (!report) {
      ++refused;
      EXPECT_EQ(report.error().remedy, Remedy::Remesh) << seed << report.error().text();
      EXPECT_EQ(mesh.triangles, given.triangles);
      report = mendSurface(mesh, {.remesh = 0.1});
    }
    ASSERT_TRUE(report) << seed << ": " << report.error().text();
    EXPECT_TRUE(boundsASolid(mesh)) << seed;
    // Mended once is mended for good.
    TriangleMesh again = merged(mesh);
    const auto second = mendSurface(again);
    ASSERT_TRUE(second) << seed << ": " << second.error().text();
    EXPECT_TRUE(second->changes.empty()) << seed << ": " << second->changes.front().text;
  }
  RecordProperty("refused", refused);
  EXPECT_LT(refused, kSeeds / 10);
}

TEST(MendSurface, MendsTheDamagedFixtures) {
  for (const auto& surface : fixtures::damagedSurfaces()) {
    TriangleMesh mesh = soupOf(surface.mesh);
    EXPECT_FALSE(mended(mesh).empty()) << surface.name;
    if (surface.name == "touching-cubes") {
      EXPECT_NEAR(signedVolume(mesh), 3000, 0.2);
    }
  }
}

TEST(MendSurface, MendsRealMeshes) {
  const std::filesystem::path folder = T4D_SHARED_MESHES;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".obj") continue;
    auto loaded = formats::readTriangleMesh(entry.path());
    ASSERT_TRUE(loaded) << loaded.error().text();
    const auto report = mendSurface(loaded->mesh);
    ASSERT_TRUE(report) << entry.path() << report.error().text();
    EXPECT_TRUE(boundsASolid(loaded->mesh)) << entry.path();
  }
}

TEST(MendSurface, SheetsBecomeSolidsOfTheirAreaTimesTheThickness) {
  // A cube without a side, and a rectangle of 2 x 3.
  TriangleMesh mesh = fixtures::cube(1);
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Point3& p : {Point3(5, 0, 0), Point3(7, 0, 0), Point3(7, 3, 0), Point3(5, 3, 0)}) {
    mesh.vertices.push_back(p);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  TriangleMesh without = mesh;
  const auto lost = mendSurface(without);
  ASSERT_TRUE(lost) << lost.error().text();
  EXPECT_EQ(lost->lost.triangles, 2U);
  const auto report = mendSurface(mesh, {.thicken = 0.01});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(model::checkClosedSurface(mesh));
  EXPECT_EQ(report->components, 2U);
  EXPECT_NEAR(signedVolume(mesh), 1 + 6 * 0.01, 1e-12);
}

}  // namespace
}  // namespace t4d::edit
