#include "t4d/conformance/answers.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/writer.h"
#include "tests/paths.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The body of the specification's example.
model::Mesh unitSimplex() {
  model::Slab slab;
  slab.timeEnd = 1;
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  slab.connectivity = connectivity;
  model::Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

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

}  // namespace
}  // namespace t4d::conformance
