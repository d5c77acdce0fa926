#include "convert/attribute_colors.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "convert/frame_slices.h"
#include "fixtures/solids.h"
#include "formats/triangle/written_mesh.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

using formats::Color;
using formats::NamedMesh;
using model::Attribute;
using model::Domain;

NamedMesh cubeWith(Attribute attribute) {
  NamedMesh named{"cube", fixtures::cube(2)};
  named.mesh.attributes.push_back(std::move(attribute));
  return named;
}

double brightness(const Color& color) {
  return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
}

TEST(AttributeColors, OfNumbersGetBrighterFromTheSmallestToTheLargest) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT(brightness(rampColor(i / 100.0)), brightness(rampColor((i + 1) / 100.0)));
  }
  const std::vector<double> numbers = {3, -1, 0.5, NAN, 2, 3, 1, 1};
  NamedMesh named = cubeWith(model::makeAttribute("heat", Domain::Vertex, numbers));
  const auto colors = attributeColors("heat", false, {&named, 1});
  ASSERT_TRUE(colors) << colors.error().text();
  EXPECT_EQ(colors->low, -1);
  EXPECT_EQ(colors->high, 3);
  colors->paint(named);
  ASSERT_TRUE(named.colors);
  EXPECT_EQ(named.colors->domain, Domain::Vertex);
  const auto bytes = [&](std::size_t row) { return formats::sRgbOf(named, Domain::Vertex, row); };
  EXPECT_EQ(bytes(0), (std::array<std::uint8_t, 4>{253, 231, 37, 255}));
  EXPECT_EQ(bytes(1), (std::array<std::uint8_t, 4>{68, 1, 84, 255}));
  EXPECT_EQ(bytes(3), formats::sRgbOf(Color{0.5, 0.5, 0.5, 1}));
  EXPECT_EQ(bytes(6), (std::array<std::uint8_t, 4>{33, 145, 140, 255}));
}

TEST(AttributeColors, OfBytesAreThoseBytes) {
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < 8 * 4; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 37));
  Attribute attribute = model::makeAttribute("rgba", Domain::Vertex, bytes);
  attribute.components = 4;
  NamedMesh named = cubeWith(attribute);
  const auto colors = attributeColors("rgba", false, {&named, 1});
  ASSERT_TRUE(colors) << colors.error().text();
  colors->paint(named);
  for (std::size_t row = 0; row < 8; ++row) {
    const auto found = formats::sRgbOf(named, Domain::Vertex, row);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(found[i], bytes[4 * row + i]);
  }
}

TEST(AttributeColors, OfTrianglesAreDistinctAndTheSameAtAllTimes) {
  std::set<std::array<std::uint8_t, 4>> seen;
  for (std::uint64_t i = 0; i < 100; ++i) seen.insert(formats::sRgbOf(distinctColor(i)));
  EXPECT_EQ(seen.size(), 100U);
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  const model::ScrewRun rest{1, {}, 1};
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&rest, 1}), options, mesh));
  const model::Body body{"cube", &mesh};
  const auto colors = attributeColors("triangle", true, {&body, 1});
  ASSERT_TRUE(colors) << colors.error().text();
  std::set<std::array<std::uint8_t, 4>> used;
  const std::vector<double> times = {0, 0.4, 1};
  const auto done = forEachFrame(
      {&body, 1}, times, {.paint = [&](NamedMesh& named, double) { colors->paint(named); }},
      [&](std::size_t, std::span<const NamedMesh> meshes) -> Result<void> {
        const NamedMesh& named = meshes.front();
        EXPECT_EQ(named.colors->colors.size(), named.mesh.triangles.size());
        for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
          used.insert(formats::sRgbOf(named, Domain::Cell, i));
        }
        return {};
      });
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(used.size(), 12U);
}

TEST(AttributeColors, OfWhatIsNoColorAreRefused) {
  Attribute pair = model::makeAttribute("pair", Domain::Vertex, std::vector<float>(16));
  pair.components = 2;
  const NamedMesh named = cubeWith(pair);
  const auto why = [&](const char* name, bool distinct) {
    return attributeColors(name, distinct, {&named, 1}).error().message;
  };
  EXPECT_EQ(why("pair", false),
            "attribute 'pair' has 2 components, expected 1, or 3 or 4 for colours");
  EXPECT_EQ(why("heat", false), "there is no attribute 'heat'; there is pair");
  EXPECT_EQ(why("pair", true), "attribute 'pair' is not a whole number");
}

}  // namespace
}  // namespace t4d::convert
