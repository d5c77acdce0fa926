#include "convert/first_looks.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "fixtures/solids.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

/// A torus that turns in two steps, with a direction and a temperature at each vertex, and, from
/// the time of each vertex of the 4D mesh, its age.
model::Mesh agingTorus() {
  model::TriangleMesh solid = fixtures::torus(3, 1, 9, 5);
  std::vector<float> heat;
  std::vector<float> wind;
  for (const model::Point3& vertex : solid.vertices) {
    heat.push_back(static_cast<float>(vertex.x()));
    wind.insert(wind.end(), {1, 0, static_cast<float>(vertex.z())});
  }
  solid.attributes = {model::makeAttribute("heat", model::Domain::Vertex, heat),
                      model::makeAttribute("wind", model::Domain::Vertex, wind)};
  solid.attributes[1].components = 3;
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  options.steps = mesh4d::StepsPerSegment{2};
  model::Screw screw;
  screw.angleDegrees = 40;
  const model::ScrewRun run{1, screw, 1};
  model::Mesh swept;
  EXPECT_TRUE(mesh4d::sweep(solid, *model::chainScrews(0, {&run, 1}), options, swept));
  model::Mesh mesh;
  for (model::Slab slab : swept.slabs()) {
    std::vector<double> age;
    for (const model::Point4& vertex : slab.vertices) age.push_back(vertex.w());
    slab.attributes.push_back(model::makeAttribute("age", model::Domain::Vertex, age));
    EXPECT_TRUE(mesh.put(slab));
  }
  return mesh;
}

TEST(FirstLooks, AreTheAttributesThatStayRight) {
  const model::Mesh mesh = agingTorus();
  const model::Body body{"torus", &mesh};
  formats::NamedMesh named{"torus", slice::LightSlicer(mesh).at(0.25)->slice.mesh};
  const std::vector<model::Attribute> sliced = named.mesh.attributes;
  named.mesh.attributes.clear();
  FlipbookOptions options;
  EXPECT_TRUE(addFirstLooks(body, {0.25, 1}, options, named)->empty());
  EXPECT_TRUE(named.mesh.attributes.empty());

  options.write.attributes = true;
  options.meanings["wind"].kind = "vector";
  const auto losses = addFirstLooks(body, {0.25, 1}, options, named);
  ASSERT_TRUE(losses) << losses.error().text();
  EXPECT_THAT(*losses,
              testing::UnorderedElementsAre(
                  "attribute 'wind': its values are directions or points, which would not move "
                  "along",
                  "attribute 'age': its values change over time, and are those of the first time"));
  std::vector<model::Attribute> expected = sliced;
  std::erase_if(expected, [](const auto& attribute) { return attribute.name == "wind"; });
  EXPECT_EQ(named.mesh.attributes, expected);
  EXPECT_EQ(std::ranges::count(expected, "age", &model::Attribute::name), 1);
  EXPECT_EQ(std::ranges::count(expected, "heat", &model::Attribute::name), 1);
}

}  // namespace
}  // namespace t4d::convert
