#include "conformance/answers.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/shapes.h"
#include "platform/crc32c.h"
#include "t4d/file.h"
#include "tests/paths.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The body of the specification's example.
model::Slab unitSimplexSlab() {
  model::Slab slab;
  slab.timeEnd = 1;
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  slab.connectivity = connectivity;
  return slab;
}

model::Mesh meshOf(const std::vector<model::Slab>& slabs) {
  model::Mesh mesh;
  for (const model::Slab& slab : slabs) EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

model::Mesh unitSimplex() { return meshOf({unitSimplexSlab()}); }

/// The n-th block of JSON in the specification.
json jsonInSpec(int n) {
  std::ifstream spec(T4D_SPEC);
  std::string line;
  std::string text;
  while (n >= 0 && std::getline(spec, line)) n -= line == "```json";
  while (std::getline(spec, line) && line != "```") text += line;
  return json::parse(text);
}

TEST(Answers, AreThoseOfTheSpecificationsExample) {
  model::Mesh mesh = unitSimplex();
  const auto description = describe({{"simplex", &mesh}}, {1, 0}, {"means"});
  ASSERT_TRUE(description);
  EXPECT_EQ(jsonInSpec(0), json::parse(description->json));
  const auto slice = sliceAt({{"simplex", &mesh}}, 0.5);
  ASSERT_TRUE(slice);
  EXPECT_EQ(jsonInSpec(1), json::parse(slice->json));
  // A corner of a cube of side 1/2.
  const json body = json::parse(slice->json)["bodies"][0];
  EXPECT_NEAR(std::stod(body["volume"].get<std::string>()), 1.0 / 48, 1e-16);
  EXPECT_NEAR(std::stod(body["area"].get<std::string>()), (3 + std::sqrt(3.0)) / 8, 1e-15);
}

TEST(Answers, AreEmptyOutsideTheTimes) {
  model::Mesh mesh = unitSimplex();
  for (const double time : {-0.5, 1.5}) {
    const auto slice = sliceAt({{"simplex", &mesh}}, time);
    ASSERT_TRUE(slice);
    const json body = json::parse(slice->json)["bodies"][0];
    EXPECT_EQ(body["triangles"], "0");
    EXPECT_TRUE(body["min"].is_null());
  }
}

TEST(Answers, DifferWhereTheyAreWrongAndNotWhereTheyAreRounded) {
  model::Mesh mesh = unitSimplex();
  const auto answer = sliceAt({{"simplex", &mesh}}, 0.5);
  const json expected = json::parse(answer->json);
  EXPECT_THAT(differences(*answer, answer->json), IsEmpty());
  json actual = expected;
  actual["bodies"][0]["volume"] = "0.0208333333333";  // 1/48, rounded
  actual["bodies"][0]["more"] = 1;
  EXPECT_THAT(differences(*answer, actual.dump()), IsEmpty());
  actual["bodies"][0]["volume"] = "-0.0208333333333";
  EXPECT_THAT(differences(*answer, actual.dump()),
              ElementsAre(HasSubstr("bodies[0].volume is -0.0208")));
  actual = expected;
  actual["bodies"][0]["points"] = 4;
  EXPECT_THAT(differences(*answer, actual.dump()), ElementsAre("bodies[0].points is not a string"));
  actual["bodies"] = json::array();
  EXPECT_THAT(differences(*answer, actual.dump()), ElementsAre("bodies has 0 entries, not 1"));
  EXPECT_THAT(differences(*answer, "null"), ElementsAre("the answer is not an object"));

  const auto description = describe({{"simplex", &mesh}}, {1, 0}, {});
  actual = json::parse(description->json);
  actual["bodies"][0]["slabs"][0]["max"][3] = "0x1.0000000000001p+0";
  EXPECT_THAT(differences(*description, actual.dump()),
              ElementsAre(HasSubstr("bodies[0].slabs[0].max[3] is")));
}

/// Bounds, counts and hypervolume do not tell these meshes apart.
TEST(Answers, DifferInChecksumsWhereNothingElseDoes) {
  const auto answerOf = [](const model::Slab& slab) {
    model::Mesh mesh = meshOf({slab});
    return describe({{"simplex", &mesh}}, {1, 0}, {}).value();
  };
  const Answer right = answerOf(unitSimplexSlab());

  model::Slab turned = unitSimplexSlab();
  auto connectivity = std::make_shared<model::Connectivity>(*turned.connectivity);
  model::Cell& cell = connectivity->cells[0];
  std::rotate(cell.begin(), cell.begin() + 1, cell.begin() + 3);  // an even permutation
  turned.connectivity = connectivity;
  EXPECT_THAT(differences(right, answerOf(turned).json),
              ElementsAre(HasSubstr("bodies[0].cells_checksum is")));

  model::Slab negative = unitSimplexSlab();
  negative.vertices[0][1] = -0.0;
  EXPECT_THAT(differences(right, answerOf(negative).json),
              ElementsAre(HasSubstr("bodies[0].vertices_checksum is")));
}

TEST(Answers, HaveChecksumsOfAllSlabsOneAfterAnother) {
  const std::vector<model::Slab> slabs = crossPolytope();
  model::Mesh mesh = meshOf(slabs);
  const json body = json::parse(describe({{"cross", &mesh}}, {1, 0}, {})->json)["bodies"][0];
  std::vector<model::Point4> vertices;  // those of the layer twice
  std::vector<model::Cell> cells;
  for (const model::Slab& slab : slabs) {
    vertices.insert(vertices.end(), slab.vertices.begin(), slab.vertices.end());
    const std::vector<model::Cell>& more = slab.connectivity->cells;
    cells.insert(cells.end(), more.begin(), more.end());
  }
  const auto checksum = [&](const char* member) {
    return std::stoul(body[member].get<std::string>(), nullptr, 16);
  };
  EXPECT_EQ(checksum("vertices_checksum"), platform::crc32c(vertices.data(), vertices.size() * 32));
  EXPECT_EQ(checksum("cells_checksum"), platform::crc32c(cells.data(), cells.size() * 16));
}

}  // namespace
}  // namespace t4d::conformance
