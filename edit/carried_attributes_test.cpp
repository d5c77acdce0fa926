#include "edit/carried_attributes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/corner_attributes.h"
#include "model/surface_check.h"
#include "t4d/edit.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Domain;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;

template <class T>
Attribute rows(std::string name, Domain domain, std::uint32_t components, std::vector<T> numbers) {
  Attribute attribute = model::makeAttribute(std::move(name), domain, numbers);
  attribute.components = components;
  return attribute;
}

/// The bytes of an attribute at a corner, whether it is one of vertices or of corners.
std::vector<std::byte> atCorner(const TriangleMesh& mesh, const std::string& name,
                                std::size_t triangle, std::size_t corner) {
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.name == name && attribute.domain == Domain::Vertex) {
      const auto* row = attribute.row(mesh.triangles[triangle][corner]);
      return {row, row + attribute.rowBytes()};
    }
    if (attribute.name == name + std::string(model::kCornersOf)) {
      const std::size_t bytes = attribute.rowBytes() / 3;
      const auto* row = attribute.row(triangle) + corner * bytes;
      return {row, row + bytes};
    }
  }
  ADD_FAILURE() << name;
  return {};
}

std::vector<std::byte> ofTriangle(const TriangleMesh& mesh, const std::string& name,
                                  std::size_t triangle) {
  const auto found = std::ranges::find(mesh.attributes, name, &Attribute::name);
  if (found == mesh.attributes.end()) return {};
  return {found->row(triangle), found->row(triangle) + found->rowBytes()};
}

std::vector<float> floatsAt(const TriangleMesh& mesh, const std::string& name, std::size_t triangle,
                            std::size_t corner) {
  const auto bytes = atCorner(mesh, name, triangle, corner);
  std::vector<float> floats(bytes.size() / sizeof(float));
  std::memcpy(floats.data(), bytes.data(), bytes.size());
  return floats;
}

std::uint32_t materialOf(const TriangleMesh& mesh, std::size_t triangle) {
  const auto bytes = ofTriangle(mesh, "material", triangle);
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data(), sizeof number);
  return number;
}

using Coordinates = std::array<double, 3>;

Coordinates coordinatesOf(const TriangleMesh& mesh, std::uint32_t vertex) {
  const Point3& p = mesh.vertices[vertex];
  return {p.x(), p.y(), p.z()};
}

std::set<Coordinates> placesOf(const TriangleMesh& mesh, const Triangle& triangle) {
  std::set<Coordinates> places;
  for (const std::uint32_t corner : triangle) places.insert(coordinatesOf(mesh, corner));
  return places;
}

/// Vertex attributes that differ everywhere, corner attributes with seams, and numbers of
/// triangles.
void addRandomAttributes(TriangleMesh& mesh, std::mt19937& random) {
  std::uniform_real_distribution<float> real(-5, 5);
  std::uniform_int_distribution<int> byte(0, 255);
  std::vector<float> heat;
  std::vector<std::uint8_t> color;
  std::vector<float> uv;
  std::vector<std::uint32_t> material;
  std::vector<double> weight;
  for (std::size_t i = 0; i < 2 * mesh.vertices.size(); ++i) heat.push_back(real(random));
  for (std::size_t i = 0; i < 3 * mesh.vertices.size(); ++i) {
    color.push_back(static_cast<std::uint8_t>(byte(random)));
  }
  for (std::size_t i = 0; i < 6 * mesh.triangles.size(); ++i) uv.push_back(real(random));
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    material.push_back(i % 7);
    weight.push_back(double{real(random)});
  }
  mesh.attributes = {rows("heat", Domain::Vertex, 2, heat), rows("color", Domain::Vertex, 3, color),
                     rows("uv:corners", Domain::Cell, 6, uv),
                     rows("material", Domain::Cell, 1, material),
                     rows("weight", Domain::Cell, 1, weight)};
}

/// How many triangles are those of before. Each has exactly the rows that it had.
std::size_t countKept(const TriangleMesh& before, const TriangleMesh& after) {
  std::map<std::set<Coordinates>, std::size_t> known;
  for (std::size_t i = 0; i < before.triangles.size(); ++i) {
    known.emplace(placesOf(before, before.triangles[i]), i);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    const auto found = known.find(placesOf(after, after.triangles[i]));
    if (found == known.end()) continue;
    ++kept;
    for (const char* name : {"material", "weight"}) {
      EXPECT_EQ(ofTriangle(after, name, i), ofTriangle(before, name, found->second)) << name;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle& old = before.triangles[found->second];
      const auto place = coordinatesOf(after, after.triangles[i][k]);
      const auto at = std::ranges::find_if(
          old, [&](std::uint32_t vertex) { return coordinatesOf(before, vertex) == place; });
      for (const char* name : {"heat", "color", "uv"}) {
        EXPECT_EQ(atCorner(after, name, i, k),
                  atCorner(before, name, found->second, static_cast<std::size_t>(at - old.begin())))
            << name;
      }
    }
  }
  return kept;
}

TriangleMesh mendedOf(TriangleMesh mesh, const MendSurfaceOptions& options = {}) {
  const auto report = mendSurface(mesh, options);
  EXPECT_TRUE(report) << report.error().text();
  EXPECT_TRUE(model::checkClosedSurface(mesh));
  for (const Attribute& attribute : mesh.attributes) {
    EXPECT_EQ(attribute.rows(),
              attribute.domain == Domain::Vertex ? mesh.vertices.size() : mesh.triangles.size());
  }
  return mesh;
}

TEST(CarriedAttributes, TrianglesThatSurviveHaveTheirRows) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const auto chance = [&](int of) {
      return std::uniform_int_distribution<int>(1, of)(random) == 1;
    };
    TriangleMesh mesh = seed % 2 == 0 ? fixtures::icosphere(2, 3) : fixtures::torus(3, 1, 20, 12);
    if (seed % 3 == 0) {
      // Crosses the first solid.
      const TriangleMesh other = fixtures::translated(fixtures::icosphere(1, 2), {2.1, 0.3, 0.2});
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Point3& p : other.vertices) mesh.vertices.emplace_back(p);
      for (const auto& [a, b, c] : other.triangles) {
        mesh.triangles.push_back({first + a, first + b, first + c});
      }
    }
    std::erase_if(mesh.triangles, [&](const Triangle&) { return chance(25); });
    for (Triangle& triangle : mesh.triangles) {
      if (chance(12)) std::swap(triangle[0], triangle[2]);
    }
    if (seed % 4 < 2) {
      // A soup: each triangle has vertices, and so values, of its own.
      TriangleMesh soup;
      for (const Triangle& triangle : mesh.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const std::uint32_t corner : triangle)
          soup.vertices.emplace_back(mesh.vertices[corner]);
        soup.triangles.push_back({first, first + 1, first + 2});
      }
      mesh = std::move(soup);
    }
    addRandomAttributes(mesh, random);
    const TriangleMesh after = mendedOf(mesh);
    EXPECT_EQ(after.attributes.size(), mesh.attributes.size());
    EXPECT_GT(countKept(mesh, after), mesh.triangles.size() / 2) << seed;
  }
}

TEST(CarriedAttributes, AHoleHasColoursWithinTheRangeOfItsRim) {
  TriangleMesh mesh = fixtures::icosphere(1, 4);
  // The mesh loses what is above a plane.
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return std::ranges::any_of(triangle,
                               [&](std::uint32_t v) { return mesh.vertices[v].z() > 0.8; });
  });
  std::vector<float> color;
  for (const Point3& p : mesh.vertices) {
    for (const double number : {p.x(), p.y(), p.z()}) color.push_back(static_cast<float>(number));
  }
  mesh.attributes = {rows("color", Domain::Vertex, 3, color)};
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[std::minmax({t[k], t[(k + 1) % 3]})];
  }
  float low = 2;
  float high = -2;
  for (const auto& [edge, count] : edges) {
    if (count == 2) continue;
    for (const std::uint32_t vertex : {edge.first, edge.second}) {
      low = std::min(low, color[3 * vertex + 2]);
      high = std::max(high, color[3 * vertex + 2]);
    }
  }
  const std::size_t given = mesh.triangles.size();
  const TriangleMesh after = mendedOf(mesh);
  ASSERT_GT(after.triangles.size(), given + 20);
  EXPECT_EQ(after.attributes.front().domain, Domain::Vertex);
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto values = floatsAt(after, "color", i, k);
      if (i >= given) {
        EXPECT_THAT(values[2], testing::AllOf(testing::Ge(low), testing::Le(high)));
      }
      // The colours are the coordinates, which fillings do not change.
      EXPECT_EQ(values[0], static_cast<float>(after.vertices[after.triangles[i][k]].x()));
    }
  }
}

/// A torus with texture coordinates once around and once across, and a seam for each.
TriangleMesh wrappedTorus(int around, int across) {
  TriangleMesh mesh = fixtures::torus(3, 1, around, across);
  std::vector<float> uv;
  for (const Triangle& triangle : mesh.triangles) {
    std::array<std::array<double, 2>, 3> at{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3& p = mesh.vertices[triangle[k]];
      at[k] = {std::atan2(p.y(), p.x()), std::atan2(p.z(), std::hypot(p.x(), p.y()) - 3)};
      // Coordinates are those on the side of the seam where the triangle is.
      for (std::size_t i = 0; i < 2; ++i) {
        while (at[k][i] - at[0][i] > std::numbers::pi) at[k][i] -= 2 * std::numbers::pi;
        while (at[k][i] - at[0][i] < -std::numbers::pi) at[k][i] += 2 * std::numbers::pi;
        uv.push_back(static_cast<float>(at[k][i] / (2 * std::numbers::pi)));
      }
    }
  }
  mesh.attributes = {rows("uv:corners", Domain::Cell, 6, uv)};
  return mesh;
}

TEST(CarriedAttributes, AHoleInATorusHasTheTextureCoordinatesOfItsRim) {
  TriangleMesh mesh = wrappedTorus(24, 12);
  const TriangleMesh whole = mesh;
  // Around some vertices, away from the seams.
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Point3& p = mesh.vertices[mesh.triangles[i][0]];
    if ((p - Point3(0, 3, 1)).norm() > 0.7) kept.push_back(i);
  }
  ASSERT_LT(kept.size(), mesh.triangles.size() - 4);
  std::vector<Triangle> triangles;
  for (const std::uint32_t i : kept) triangles.push_back(mesh.triangles[i]);
  mesh.triangles = triangles;
  Attribute& uv = mesh.attributes.front();
  std::vector<std::byte> values;
  for (const std::uint32_t i : kept) {
    const auto* row = whole.attributes.front().row(i);
    values.insert(values.end(), row, row + uv.rowBytes());
  }
  uv.values = values;
  const TriangleMesh after = mendedOf(mesh);
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3& p = after.vertices[after.triangles[i][k]];
      const auto at = floatsAt(after, "uv", i, k);
      const double u = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi) - double{at[0]};
      const double v =
          std::atan2(p.z(), std::hypot(p.x(), p.y()) - 3) / (2 * std::numbers::pi) - double{at[1]};
      EXPECT_NEAR(u, std::round(u), 1e-6);
      EXPECT_NEAR(v, std::round(v), 1e-6);
      if (i < kept.size()) continue;
      EXPECT_NEAR(at[0], 0.25, 0.15);
      EXPECT_NEAR(at[1], 0.25, 0.25);
    }
  }
}

/// Two balls, with one colour and one material each, and a coordinate.
TriangleMesh twoBalls() {
  TriangleMesh mesh = fixtures::icosphere(1, 3);
  const TriangleMesh other = fixtures::translated(mesh, {1.1, 0.2, 0.1});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const std::size_t half = mesh.triangles.size();
  for (const Point3& p : other.vertices) mesh.vertices.emplace_back(p);
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
  std::vector<std::uint32_t> material(2 * half, 1);
  std::fill(material.begin() + static_cast<std::ptrdiff_t>(half), material.end(), 2);
  std::vector<float> color(first, 0.25F);
  color.resize(2 * std::size_t{first}, 0.75F);
  std::vector<float> x;
  for (const Point3& p : mesh.vertices) x.push_back(static_cast<float>(p.x()));
  mesh.attributes = {rows("color", Domain::Vertex, 1, color), rows("x", Domain::Vertex, 1, x),
                     rows("material", Domain::Cell, 1, material)};
  return mesh;
}

TEST(CarriedAttributes, PiecesOfAUnionHaveWhatTheirSolidHas) {
  const TriangleMesh after = mendedOf(twoBalls());
  std::array<int, 3> counts{};
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    const std::uint32_t material = materialOf(after, i);
    ++counts[material];
    const Point3 centre = material == 1 ? Point3(0, 0, 0) : Point3(1.1, 0.2, 0.1);
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3& p = after.vertices[after.triangles[i][k]];
      EXPECT_NEAR((p - centre).norm(), 1, 0.02);
      EXPECT_EQ(floatsAt(after, "color", i, k).front(), material == 1 ? 0.25F : 0.75F);
      EXPECT_NEAR(floatsAt(after, "x", i, k).front(), p.x(), 1e-6);
    }
  }
  EXPECT_GT(counts[1], 500);
  EXPECT_GT(counts[2], 500);
  // Both balls have the same coordinate where they meet, but each its own colour.
  EXPECT_EQ(after.attributes[0].name, "color:corners");
  EXPECT_EQ(after.attributes[1].name, "x");
}

TEST(CarriedAttributes, ASurfaceOfVoxelsHasWhatIsNearest) {
  // A third solid that is open and has one side makes it unmendable without voxels.
  TriangleMesh mesh = twoBalls();
  constexpr double kVoxel = 0.05;
  const std::size_t given = mesh.triangles.size();
  // A Moebius strip of triangles inside, which has one side.
  std::vector<float> color(mesh.vertices.size());
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  constexpr std::uint32_t kParts = 9;
  for (std::uint32_t i = 0; i < kParts; ++i) {
    const double a = 2 * std::numbers::pi * i / kParts;
    const Point3 across =
        0.1 * Point3(std::cos(a) * std::cos(a / 2), std::sin(a) * std::cos(a / 2), std::sin(a / 2));
    const Point3 middle = 0.3 * Point3(std::cos(a), std::sin(a), 0);
    mesh.vertices.emplace_back(middle - across);
    mesh.vertices.emplace_back(middle + across);
  }
  for (std::uint32_t i = 0; i < kParts; ++i) {
    std::array<std::uint32_t, 2> from = {first + 2 * i, first + 2 * i + 1};
    std::array<std::uint32_t, 2> to = {first + 2 * i + 2, first + 2 * i + 3};
    if (i + 1 == kParts) to = {first + 1, first};
    mesh.triangles.push_back({from[0], to[0], from[1]});
    mesh.triangles.push_back({from[1], to[0], to[1]});
  }
  for (Attribute& attribute : mesh.attributes) {
    const std::size_t count =
        attribute.domain == Domain::Vertex ? mesh.vertices.size() : mesh.triangles.size();
    attribute.values.resize(count * attribute.rowBytes());
  }
  ASSERT_GT(mesh.triangles.size(), given);
  MendSurfaceOptions options;
  options.remesh = kVoxel;
  TriangleMesh after = mesh;
  const auto report = mendSurface(after, options);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_TRUE(std::ranges::any_of(report->changes, [](const SurfaceChange& change) {
    return change.kind == SurfaceFault::Remeshed;
  }));
  EXPECT_EQ(after.attributes.at(1).name, "x");
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    const auto& t = after.triangles[i];
    const Point3 middle = (after.vertices[t[0]] + after.vertices[t[1]] + after.vertices[t[2]]) / 3;
    const double toFirst = std::abs(middle.norm() - 1);
    const double toSecond = std::abs((middle - Point3(1.1, 0.2, 0.1)).norm() - 1);
    // The material is certain where one ball is clearly nearer.
    if (std::abs(toFirst - toSecond) > kVoxel) {
      EXPECT_EQ(materialOf(after, i), toFirst < toSecond ? 1U : 2U);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(floatsAt(after, "x", i, k).front(), after.vertices[t[k]].x(), 2 * kVoxel);
    }
  }
}

TEST(CarriedAttributes, BothSidesOfAThickSheetHaveWhatTheSheetHas) {
  TriangleMesh mesh;
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 5; ++k) mesh.vertices.emplace_back(i, k, 0);
  }
  std::vector<std::uint32_t> material;
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t at = 5 * i + k;
      mesh.triangles.push_back({at, at + 5, at + 6});
      mesh.triangles.push_back({at, at + 6, at + 1});
      material.insert(material.end(), 2, 4 * i + k);
    }
  }
  mesh.attributes = {rows("material", Domain::Cell, 1, material)};
  MendSurfaceOptions options;
  options.thicken = 0.1;
  const TriangleMesh after = mendedOf(mesh, options);
  std::map<std::uint32_t, int> counts;
  for (std::size_t i = 0; i < after.triangles.size(); ++i) ++counts[materialOf(after, i)];
  EXPECT_EQ(after.triangles.size(), 2 * 32 + 2 * 16);
  // The rim has two triangles for each of the 16 edges, with the number of the triangle inside.
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const int rims = (i == 0 || i == 3 ? 1 : 0) + (k == 0 || k == 3 ? 1 : 0);
      EXPECT_EQ(counts[4 * i + k], 4 + 2 * rims) << i << " " << k;
    }
  }
}

}  // namespace
}  // namespace t4d::edit
