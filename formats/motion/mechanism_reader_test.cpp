#include "formats/motion/mechanism_reader.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "fixtures/mechanisms.h"
#include "formats/motion/basic_solids.h"
#include "formats/motion/joint_table.h"
#include "formats/test_files.h"
#include "model/surface_check.h"

namespace t4d::formats {
namespace {

using model::Point3;
using nlohmann::json;
using testing::HasSubstr;

const fixtures::MechanismFile& fixture(const std::string& name) {
  static const auto files = fixtures::mechanismFiles();
  return *std::ranges::find(files, name, &fixtures::MechanismFile::name);
}

std::filesystem::path fixtureFile(const std::string& name) {
  return writeFile(name, fixture(name).text);
}

Result<LoadedMechanism> read(const json& value) {
  return readMechanism(writeFile("m.json", value.dump()));
}

std::string errorOf(const json& value) {
  const auto read = readMechanism(writeFile("m.json", value.dump()));
  return read ? "(was accepted)" : read.error().text();
}

std::size_t linkOf(const LoadedMechanism& loaded, const std::string& name) {
  const auto& links = loaded.mechanism.links;
  return static_cast<std::size_t>(std::ranges::find(links, name, &model::Link::name) -
                                  links.begin());
}

TEST(BasicSolids, AreClosedAndHaveTheirVolume) {
  const double sides = kRoundSides;
  const double polygon = sides / 2 * std::sin(2 * std::numbers::pi / sides);
  const std::pair<model::TriangleMesh, double> solids[] = {{boxMesh({1, 2, 3}), 6},
                                                           {cylinderMesh(2, 5), 4 * polygon * 5}};
  for (const auto& [mesh, volume] : solids) {
    EXPECT_TRUE(model::checkClosedSurface(mesh));
    EXPECT_NEAR(signedVolume(mesh), volume, 1e-12 * volume);
  }
  const model::TriangleMesh sphere = sphereMesh(2);
  EXPECT_TRUE(model::checkClosedSurface(sphere));
  EXPECT_GT(signedVolume(sphere), 0.99 * 4 / 3.0 * std::numbers::pi * 8);
  for (const Point3& vertex : sphere.vertices) EXPECT_NEAR(vertex.norm(), 2, 1e-14);
}

TEST(MechanismReader, TheArmHasEightBodies) {
  const auto loaded = readMechanism(fixtureFile("arm.json"));
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded->solids.size(), 8U);
  EXPECT_EQ(loaded->lengthUnit, "mm");
  EXPECT_THAT(loaded->notices, testing::IsEmpty());
  EXPECT_EQ(loaded->mechanism.span()->end, 4);
  // At time 1.5 the first joint is at 90 degrees, the second at 80.
  const model::Pose pose = loaded->mechanism.at(linkOf(*loaded, "link 2"), 1.5);
  const double radians = 80 * std::numbers::pi / 180;
  EXPECT_LE((pose({0, 0, 260}) - Point3(0, 100 * std::sin(radians), 160 + 100 * std::cos(radians)))
                .norm(),
            1e-12);
}

// Coupler and rocker meet where they are joined, at every sample, though they are in two chains.
TEST(MechanismReader, TheFourBarLinkageCloses) {
  const auto loaded = readMechanism(fixtureFile("four-bar.json"));
  ASSERT_TRUE(loaded) << loaded.error().text();
  const fixtures::FourBar bars;
  const auto rest = fixtures::fourBarAngles(bars, 0);
  const Point3 joint(bars.ground + bars.rocker * std::cos(rest.rocker),
                     bars.rocker * std::sin(rest.rocker), 0);
  const auto& mechanism = loaded->mechanism;
  for (const double t : mechanism.knots(linkOf(*loaded, "coupler"))) {
    const Point3 byCoupler = mechanism.at(linkOf(*loaded, "coupler"), t)(joint);
    const Point3 byRocker = mechanism.at(linkOf(*loaded, "rocker"), t)(joint);
    EXPECT_LE((byCoupler - byRocker).norm(), 1e-10) << t;
    EXPECT_NEAR((byRocker - Point3(bars.ground, 0, 0)).norm(), bars.rocker, 1e-10);
  }
}

TEST(MechanismReader, GearsTurnAgainstEachOther) {
  const auto loaded = readMechanism(fixtureFile("gears.json"));
  ASSERT_TRUE(loaded) << loaded.error().text();
  for (const double t : {0.1, 0.5, 1.7}) {
    const double wheel = std::numbers::pi * t;
    const model::Pose pose = loaded->mechanism.at(linkOf(*loaded, "pinion"), t);
    EXPECT_LE(
        (pose({50, 0, 0}) - Point3(40 + 10 * std::cos(-3 * wheel), 10 * std::sin(-3 * wheel), 0))
            .norm(),
        1e-12);
  }
}

json slider() {
  return {{"length_unit", "mm"},
          {"time_unit", "s"},
          {"angle_unit", "rad"},
          {"bodies",
           {{{"name", "a"},
             {"solid", {{"box", {1, 1, 1}}}},
             {"joint", {{"type", "prismatic"}, {"axis", {2, 0, 0}}, {"limits", {0, 3}}}},
             {"motion", {{"times", {0, 1}}, {"values", {0, 2}}}}},
            {{"name", "b"},
             {"solid", {{"sphere", 1}}},
             {"parent", "a"},
             {"joint", {{"type", "revolute"}, {"axis", {0, 0, 1}}, {"origin", {5, 0, 0}}}},
             {"motion", {{"times", {0, 1}}, {"values", {0, 1}}}}}}}};
}

TEST(MechanismReader, MotionsComeFromTablesOfJointsAndPoses) {
  writeFile("joints.csv",
            "secs,nsecs,a_m,turn_deg,/js/c/position,/js/c/velocity\n0,0,0,0,1,x\n1,500000000,"
            "0.002,90,2,y\n");
  writeFile("poses.csv", "time_ms,x_m,y_m,z_m\n0,0,0,0\n1500,0.01,0,0\n");
  json value = slider();
  value["bodies"][0]["motion"] = {{"file", "joints.csv"}, {"column", "a"}};
  value["bodies"][1]["motion"] = {{"file", "joints.csv"}, {"column", "turn"}};
  value["bodies"].push_back({{"name", "c"},
                             {"solid", {{"sphere", 1}}},
                             {"parent", "b"},
                             {"joint", {{"type", "free"}}},
                             {"motion", {{"file", "poses.csv"}}}});
  value["bodies"].push_back({{"name", "d"},
                             {"joint", {{"type", "free"}}},
                             {"motion", {{"segments", {{{"duration", 3}}}}}}});
  const auto loaded = read(value);
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded->solids.size(), 3U);
  EXPECT_EQ(loaded->mechanism.span()->end, 3);
  const model::Pose pose = loaded->mechanism.at(linkOf(*loaded, "c"), 1.5);
  // The table moves c by 10 mm, b turns it by a quarter about (5, 0), a moves it by 2 mm.
  EXPECT_LE((pose({5, 0, 0}) - Point3(5 + 2, 10, 0)).norm(), 1e-12);
  EXPECT_THAT(loaded->notices, testing::Contains(HasSubstr("'/js/c/velocity'")));
  EXPECT_THAT(loaded->notices, testing::Contains(HasSubstr("rests before and after")));
}

// A rack of 2 mm drives a pinion of radius 4 mm, which drives a second rack.
TEST(MechanismReader, RatiosAreInTheUnitsOfTheFile) {
  for (const double radian : {1.0, 180 / std::numbers::pi}) {
    json value = slider();
    value["angle_unit"] = radian == 1 ? "rad" : "deg";
    value["bodies"][1]["motion"] = {{"follows", "a"}, {"ratio", 0.25 * radian}};
    value["bodies"].push_back({{"name", "c"},
                               {"joint", {{"type", "prismatic"}, {"axis", {0, 1, 0}}}},
                               {"motion", {{"follows", "b"}, {"ratio", 4 / radian}}}});
    const auto loaded = read(value);
    ASSERT_TRUE(loaded) << loaded.error().text();
    const model::Pose pinion = loaded->mechanism.at(linkOf(*loaded, "b"), 1);
    EXPECT_NEAR(pinion.rotation(1, 0), std::sin(0.5), 1e-14);
    EXPECT_LE((loaded->mechanism.at(linkOf(*loaded, "c"), 1)({0, 0, 0}) - Point3(0, 2, 0)).norm(),
              1e-14);
  }
}

TEST(MechanismReader, SolidsHaveTheUnitOfTheirFile) {
  writeFile("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  json value = slider();
  json& body = value["bodies"][0];
  body["solid"] = "t.obj";
  const auto volume = [&] {
    const auto loaded = read(value);
    return loaded ? signedVolume(loaded->solids[0].mesh) * 6 : 0;
  };
  EXPECT_EQ(volume(), 1);
  body["unit"] = "cm";
  EXPECT_EQ(volume(), 1000);
  body["unit"] = "cubit";
  EXPECT_THAT(errorOf(value), HasSubstr("bodies[0].unit: is in 'cubit', which cannot be"));
  value.erase("length_unit");
  EXPECT_THAT(errorOf(value), HasSubstr("the mechanism has no length_unit"));
  value = slider();
  value["bodies"][0]["unit"] = "cm";
  EXPECT_THAT(errorOf(value), HasSubstr("bodies[0].unit: is given, but the body has no solid"));
}

TEST(MechanismReader, ValuesBeyondLimitsAreNoted) {
  json value = slider();
  value["bodies"][0]["joint"]["limits"] = {-1, 1.5};
  const auto loaded = read(value);
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_THAT(loaded->notices,
              testing::Contains("joint 'a' is beyond its limits, -1 to 1.5 mm, at 1 of 2 times; "
                                "the farthest is 2, at time 1"));
}

TEST(MechanismReader, RefusesWithTheMember) {
  const auto changed = [](const char* pointer, const json& to) {
    json value = slider();
    value[json::json_pointer(pointer)] = to;
    return errorOf(value);
  };
  EXPECT_THAT(changed("/bodies/1/name", "a"), HasSubstr("bodies[1].name: is 'a', the name of"));
  EXPECT_THAT(changed("/bodies/1/parent", "z"),
              HasSubstr("bodies[1].parent: is 'z', which is not a body; bodies are 'a', 'b'"));
  EXPECT_THAT(changed("/bodies/0/parent", "b"),
              HasSubstr("bodies: hang on each other: 'a', 'b', 'a'"));
  EXPECT_THAT(changed("/bodies/0/joint/type", "hinge"),
              HasSubstr("bodies[0].joint.type: is 'hinge', expected fixed, revolute"));
  EXPECT_THAT(changed("/bodies/0/joint/axis", {0, 0, 0}),
              HasSubstr("joint.axis: has no direction"));
  EXPECT_THAT(changed("/bodies/0/joint/limits", {2, -2}), HasSubstr("the lower one first"));
  EXPECT_THAT(changed("/bodies/0/joint/pitch", 1), HasSubstr("only a screw joint has a pitch"));
  EXPECT_THAT(changed("/bodies/0/joint/type", "fixed"), HasSubstr("joint.axis: is given"));
  EXPECT_THAT(changed("/bodies/0/joint", {{"type", "fixed"}}),
              HasSubstr("bodies[0].motion: is given, but the joint of the body is fixed"));
  EXPECT_THAT(changed("/bodies/0/motion/times", {0, 1, 2}),
              HasSubstr("has 2 numbers, and times 3"));
  EXPECT_THAT(changed("/bodies/0/motion/times", {1, 0}), HasSubstr("times must increase"));
  EXPECT_THAT(changed("/bodies/0/motion", json::object()), HasSubstr("says in no way how"));
  EXPECT_THAT(changed("/bodies/0/motion/column", "x"), HasSubstr("does not belong"));
  EXPECT_THAT(changed("/bodies/0/motion", {{"follows", "a"}}), HasSubstr("follows itself"));
  EXPECT_THAT(changed("/bodies/0/motion", {{"file", "no.csv"}, {"column", "a"}}),
              HasSubstr("no.csv"));
  EXPECT_THAT(changed("/bodies/0/solid", "missing.stl"), HasSubstr("bodies[0]: "));
  EXPECT_THAT(changed("/bodies/0/solid", {{"box", {1, 1, -1}}}),
              HasSubstr("solid.box: has a size"));
  EXPECT_THAT(changed("/angle_unit", "grad"), HasSubstr("expected deg or rad"));
  EXPECT_THAT(changed("/speed", 1), HasSubstr("unknown key 'speed'"));
  json value = slider();
  value.erase("angle_unit");
  EXPECT_THAT(errorOf(value), HasSubstr("bodies[1].motion: is an angle, and nothing says whether"));
  value = slider();
  for (json& body : value["bodies"]) body.erase("motion");
  EXPECT_THAT(errorOf(value), HasSubstr("have no motion"));
  writeFile("joints.csv", "time,q\n0,0\n1,1\n");
  EXPECT_THAT(changed("/bodies/0/motion", {{"file", "joints.csv"}, {"column", "a"}}),
              HasSubstr("does not have; its columns are 'q'"));
  const auto motion = readMechanism(writeFile("m.json", R"({"segments": [{"duration": 1}]})"));
  ASSERT_FALSE(motion);
  EXPECT_THAT(motion.error().text(), HasSubstr("is the motion of one solid"));
}

Result<JointTable> table(const std::string& text) { return readJointTable({"j.csv", text}, "s"); }

TEST(JointTable, NamesOfRosMessagesAreInTheirRows) {
  const auto found = table(
      "%time,field.header.frame_id,field.name0,field.name1,field.position0,field.position1,"
      "field.effort0\n1700000000000000000,,elbow,wrist,1,2,9\n1700000001000000000,,elbow,wrist,3,4,"
      "9\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->find("wrist").column->values, (std::vector<double>{2, 4}));
  EXPECT_EQ(found->times, (std::vector<double>{1.7e9, 1.7e9 + 1}));
  const auto changed = table("time,field.name0,field.position0\n0,elbow,1\n1,wrist,2\n");
  ASSERT_FALSE(changed);
  EXPECT_THAT(changed.error().text(), HasSubstr("j.csv:3: column field.name0: found 'wrist'"));
}

TEST(JointTable, NamesComeBeforeUnits) {
  const auto found = table("time_ms;link_h;link_deg;slide [mm]\n0;1;2;3\n500;4;5;6\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->times[1], 0.5);
  EXPECT_EQ(found->find("link_h").unit, "");
  EXPECT_EQ(found->find("link_h").column->values[1], 4);
  EXPECT_EQ(found->find("slide").unit, "mm");
  EXPECT_EQ(found->find("arm").column, nullptr);
}

TEST(JointTable, RefusesWithTheLine) {
  const auto error = [](const std::string& text) {
    const auto found = table(text);
    return found ? std::string("(was accepted)") : found.error().text();
  };
  EXPECT_THAT(error("a,b\n0,0\n1,1\n"), HasSubstr("j.csv:1: the column of the time is missing"));
  EXPECT_THAT(error("0,0\n1,1\n"), HasSubstr("expected a first line with the names"));
  EXPECT_THAT(error("time\n0\n1\n"), HasSubstr("no column is a joint"));
  EXPECT_THAT(error("time,a\n0,0\n"), HasSubstr("has 1 row of values"));
  EXPECT_THAT(error("time,a\n0,0\n0,1\n"), HasSubstr("j.csv:3: is at time 0, as line 2"));
  EXPECT_THAT(error("time,a\n1,0\n0,1\n"), HasSubstr("j.csv:3: is at time 0, not after line 2"));
  EXPECT_THAT(error("time,a\n0,nan\n1,1\n"), HasSubstr("j.csv:2: column a: found nan"));
  EXPECT_THAT(error("time,a,a\n0,0,0\n1,1,1\n"), HasSubstr("two columns are the joint 'a'"));
}

}  // namespace
}  // namespace t4d::formats
