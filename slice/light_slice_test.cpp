#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "slice/prisms.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::slice {
namespace {

using model::Mesh;
using model::Point3;
using model::TriangleMesh;

mesh4d::SweepOptions withCones() {
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  return options;
}

Mesh lightSwept(const TriangleMesh& solid, const model::VertexKeys& keys) {
  Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, keys, withCones(), mesh));
  return mesh;
}

/// Any solid, moving in two steps from its own to random positions.
Mesh scattered(const TriangleMesh& solid, std::uint32_t seed, double by) {
  std::mt19937 random(seed);
  std::normal_distribution<double> offset;
  std::vector<model::StoredKeys::Key> keys;
  for (int key = 0; key < 3; ++key) {
    keys.push_back({0.7 * key, solid.vertices});
    for (Point3& point : keys.back().positions) {
      if (key > 0) point += by * Point3(offset(random), offset(random), offset(random));
    }
  }
  return lightSwept(solid, model::StoredKeys(std::move(keys)));
}

/// One step that turns about the z axis, and its corner farthest from that.
Mesh turnedOnce(const TriangleMesh& solid, double degrees) {
  mesh4d::SweepOptions options = withCones();
  options.steps = mesh4d::StepsPerSegment{1};
  model::Screw screw;
  screw.angleDegrees = degrees;
  screw.translation = {1, 2, 3};
  const model::ScrewRun run{1, screw, 1};
  Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, *model::chainScrews(0, {&run, 1}), options, mesh));
  return mesh;
}

const double kFractions[] = {0, 1e-9, 0.1, 0.25, 0.37, 0.5, 0.75, 0.9, 1};

TEST(LightSlice, HasTheVolumeOfTheExactSliceAndTheTrianglesOfTheInput) {
  const TriangleMesh solids[] = {fixtures::cube(2), fixtures::torus(3, 1, 12, 7),
                                 fixtures::hollowCube(3, 1), fixtures::pebble(2, 90),
                                 fixtures::twoBoxes(1, 0.5)};
  std::uint32_t seed = 0;
  for (const TriangleMesh& solid : solids) {
    for (const double by : {0.0, 0.05, 3.0}) {  // the last crosses itself, which changes nothing
      const Mesh mesh = scattered(solid, ++seed, by);
      const LightSlicer slicer(mesh);
      for (const double fraction : kFractions) {
        const double time = 1.4 * fraction;
        const auto exact = sliceAtTime(mesh, time);
        const auto light = slicer.at(time);
        ASSERT_TRUE(light) << light.error().text();
        EXPECT_TRUE(light->light) << light->whyExact;
        EXPECT_EQ(light->slice.mesh.triangles, solid.triangles);
        EXPECT_TRUE(isClosed(light->slice.mesh));
        const double volume = signedVolume(exact->mesh);
        const double size = std::pow(boundsOf(exact->mesh).max.cwiseAbs().maxCoeff(), 3);
        EXPECT_NEAR(signedVolume(light->slice.mesh), volume, 1e-12 * std::max(volume, size));
      }
    }
  }
}

TEST(LightSlice, AtALayerIsTheExactSlice) {
  const TriangleMesh solid = fixtures::torus(3, 1, 9, 5);
  const Mesh mesh = scattered(solid, 7, 0.1);
  for (const double time : {0.0, 0.7, 1.4}) {
    const auto exact = sliceAtTime(mesh, time);
    const auto light = LightSlicer(mesh).at(time);
    ASSERT_TRUE(light);
    EXPECT_EQ(light->slice.mesh.vertices, exact->mesh.vertices);
    EXPECT_EQ(light->slice.mesh.attributes, exact->mesh.attributes);
    EXPECT_EQ(light->distance, 0);
  }
}

TEST(LightSlice, HasTheAttributesOfTheInput) {
  TriangleMesh solid = fixtures::torus(3, 1, 9, 5);
  std::vector<float> heat;
  for (const Point3& vertex : solid.vertices) heat.push_back(static_cast<float>(vertex.x()));
  std::vector<std::uint16_t> part;
  for (std::size_t i = 0; i < solid.triangles.size(); ++i) {
    part.push_back(static_cast<std::uint16_t>(7 * i));
  }
  solid.attributes = {model::makeAttribute("heat", model::Domain::Vertex, heat),
                      model::makeAttribute("part", model::Domain::Cell, part)};
  const Mesh mesh = scattered(solid, 11, 0.1);
  for (const double time : {0.0, 0.3, 0.7, 1.4}) {
    const auto light = LightSlicer(mesh).at(time);
    ASSERT_TRUE(light) << light.error().text();
    const auto& attributes = light->slice.mesh.attributes;
    for (const model::Attribute& given : solid.attributes) {
      EXPECT_EQ(std::ranges::count(attributes, given), 1) << given.name << " at " << time;
    }
    EXPECT_TRUE(light->slice.losses.empty());
  }
  solid.attributes[0].values.pop_back();
  Mesh none;
  EXPECT_FALSE(mesh4d::sweep(solid, model::StoredKeys({{0, solid.vertices}, {1, solid.vertices}}),
                             withCones(), none));
}

TEST(LightSlice, IsWithinTheStatedDistanceOfTheExactSlice) {
  const TriangleMesh solids[] = {fixtures::cube(2), fixtures::torus(3, 1, 9, 5)};
  double nearest = 1;
  for (const TriangleMesh& solid : solids) {
    double longest = 0;
    for (const model::Triangle& t : solid.triangles) {
      for (int i = 0; i < 3; ++i) {
        longest = std::max(longest, (solid.vertices[t[i]] - solid.vertices[t[(i + 1) % 3]]).norm());
      }
    }
    for (const double degrees : {5.0, 40.0, 86.0}) {
      const Mesh mesh = turnedOnce(solid, degrees);
      for (const double fraction : kFractions) {
        const auto exact = sliceAtTime(mesh, fraction);
        const auto light = LightSlicer(mesh).at(fraction);
        ASSERT_TRUE(light);
        const double found =
            measure::surfaceDistance(exact->mesh, light->slice.mesh, 1e-3).hausdorff();
        EXPECT_LE(found, light->distance + 1e-12) << degrees << " " << fraction;
        // DESIGN: at most a sixth of sin(theta / 2) times the longest edge.
        const double half = degrees * std::acos(-1) / 360;
        EXPECT_LE(light->distance, longest * std::sin(half) / 6 + 1e-12);
        if (fraction == 0.25) nearest = std::min(nearest, 1 - found / light->distance);
        if (fraction == 0.5) {
          EXPECT_LT(found, 1e-12);
        }
      }
    }
  }
  EXPECT_LT(nearest, 0.8);  // the bound is not far from what is found
}

TEST(LightSlice, CarriesAttributes) {
  const TriangleMesh solid = fixtures::cube(2);
  Mesh mesh = turnedOnce(solid, 30);
  model::Slab slab = mesh.slabs()[1];
  std::vector<double> heat(slab.vertices.size());
  std::vector<std::uint8_t> tag(slab.vertices.size());
  const std::uint32_t up = slab.connectivity->firstUpper();
  for (std::uint32_t i = 0; i < heat.size(); ++i) {
    heat[i] = i < up ? i : 10.0 * (i - up);
    tag[i] = static_cast<std::uint8_t>(i);
  }
  std::vector<std::uint8_t> odd(slab.connectivity->cells.size());
  odd.back() = 1;
  slab.attributes = {model::makeAttribute("heat", model::Domain::Vertex, heat),
                     model::makeAttribute("tag", model::Domain::Vertex, tag),
                     model::makeAttribute("odd", model::Domain::Cell, odd)};
  Mesh one;
  ASSERT_TRUE(one.put(slab));
  const auto light = LightSlicer(one).at(0.25);
  ASSERT_TRUE(light);
  const auto& attributes = light->slice.mesh.attributes;
  ASSERT_EQ(attributes.size(), 5U);  // with "triangle" and "kind"
  std::vector<std::uint32_t> triangles(solid.triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) triangles[i] = i;
  EXPECT_EQ(attributes[0], model::makeAttribute("triangle", model::Domain::Cell, triangles));
  std::vector<double> expected(solid.vertices.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    expected[i] = 0.75 * static_cast<double>(i) + 2.5 * static_cast<double>(i);
  }
  EXPECT_EQ(attributes[2], model::makeAttribute("heat", model::Domain::Vertex, expected));
  EXPECT_EQ(attributes[3].row(5)[0], std::byte{5});
  EXPECT_EQ(LightSlicer(one).at(1)->slice.mesh.attributes[3].row(5)[0],
            static_cast<std::byte>(up + 5));
  ASSERT_EQ(light->slice.losses.size(), 1U);
  EXPECT_EQ(light->slice.losses[0],
            "attribute 'odd': cells of one prism differ in it; the one at its start counts");
}

/// The steps of a swept cube with another connectivity.
Mesh altered(const std::function<void(model::Connectivity&)>& alter) {
  Mesh mesh = turnedOnce(fixtures::cube(2), 30);
  model::Slab slab = mesh.slabs()[1];
  auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
  alter(*connectivity);
  slab.connectivity = connectivity;
  Mesh one;
  EXPECT_TRUE(one.put(slab));
  return one;
}

TEST(LightSlice, OfASlabThatIsNoPrismsIsTheExactSlice) {
  mesh4d::SweepOptions three = withCones();
  three.prism = mesh4d::PrismSplit::Three;
  const model::ScrewRun run{1, {}, 1};
  Mesh staircase;
  ASSERT_TRUE(
      mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&run, 1}), three, staircase));
  const Mesh withoutMeans = altered([](auto& c) { c.means = {}; });
  const Mesh turnedCell = altered([](auto& c) { std::swap(c.cells[5][0], c.cells[5][1]); });
  const Mesh missing = altered([](auto& c) {
    c.cells.pop_back();
    c.cellAttributes.clear();
  });
  const Mesh twice = altered([](auto& c) { c.cells[3] = c.cells[2]; });
  const Mesh otherMean =
      altered([](auto& c) { std::swap(c.means.sources[1], c.means.sources[5]); });
  const Mesh* meshes[] = {&staircase, &withoutMeans, &turnedCell, &missing, &twice, &otherMean};
  for (const Mesh* mesh : meshes) {
    const auto light = LightSlicer(*mesh).at(0.3);
    const auto exact = sliceAtTime(*mesh, 0.3);
    ASSERT_TRUE(light);
    EXPECT_FALSE(light->light) << mesh - meshes[0];
    EXPECT_FALSE(light->whyExact.empty());
    EXPECT_EQ(light->slice.mesh.vertices, exact->mesh.vertices);
    EXPECT_EQ(light->slice.mesh.triangles, exact->mesh.triangles);
  }
}

TEST(LightSlice, PrismsAreFoundHoweverCellsAreOrderedAndNumbered) {
  const Mesh mesh = altered([](model::Connectivity& c) {
    std::mt19937 random(5);
    std::shuffle(c.cells.begin(), c.cells.end(), random);
    for (model::Cell& cell : c.cells) {  // even permutations
      if (random() % 2 == 0) cell = {cell[1], cell[0], cell[3], cell[2]};
      if (random() % 2 == 0) std::rotate(cell.begin(), cell.begin() + 1, cell.begin() + 3);
    }
    c.cellAttributes.clear();
  });
  const auto light = LightSlicer(mesh).at(0.3);
  ASSERT_TRUE(light);
  EXPECT_TRUE(light->light) << light->whyExact;
  EXPECT_EQ(light->slice.mesh.triangles.size(), 12U);
  EXPECT_TRUE(isClosed(light->slice.mesh));
  EXPECT_NEAR(signedVolume(light->slice.mesh), signedVolume(sliceAtTime(mesh, 0.3)->mesh), 1e-12);
}

TEST(LightSlice, TimesOutsideAreRefusedAsInExactSlices) {
  const Mesh mesh = turnedOnce(fixtures::cube(2), 30);
  EXPECT_EQ(LightSlicer(mesh).at(2).error().message, sliceAtTime(mesh, 2).error().message);
  EXPECT_EQ(LightSlicer(Mesh()).at(2).error().message, sliceAtTime(Mesh(), 2).error().message);
}

}  // namespace
}  // namespace t4d::slice
