#include "formats/motion/urdf_reader.h"

#include <gmock/gmock.h>

#include "fixtures/mechanisms.h"
#include "formats/test_files.h"

namespace t4d::formats {
namespace {

using model::Point3;
using testing::Contains;
using testing::HasSubstr;

std::filesystem::path fixtureNamed(const std::string& name) {
  const auto files = fixtures::mechanismFiles();
  return writeFile(name, std::ranges::find(files, name, &fixtures::MechanismFile::name)->text);
}

// Two descriptions of one arm, by link frames in metres and by axes at rest in mm.
TEST(UrdfReader, TheArmIsThatOfTheMechanism) {
  const auto urdf = readUrdf(fixtureNamed("arm.urdf"), fixtureNamed("arm-joints.csv"));
  ASSERT_TRUE(urdf) << urdf.error().text();
  const auto arm = readMechanism(fixtureNamed("arm.json"));
  ASSERT_TRUE(arm) << arm.error().text();
  EXPECT_THAT(urdf->notices, testing::IsEmpty());
  ASSERT_EQ(urdf->solids.size(), arm->solids.size());
  EXPECT_EQ(urdf->solids[0].name, "world");
  EXPECT_EQ(urdf->solids[1].name, "world 2");
  for (std::size_t i = 0; i < arm->solids.size(); ++i) {
    for (const double t : {0.0, 0.4, 1.0, 2.9, 4.0}) {
      const auto place = [t](const LoadedMechanism& loaded, const MechanismSolid& solid) {
        return loaded.mechanism.at(solid.link, t) * solid.place;
      };
      const model::Pose metres = place(*urdf, urdf->solids[i]);
      const model::Pose millimetres = place(*arm, arm->solids[i]);
      EXPECT_LE((metres.rotation - millimetres.rotation).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_LE((1000 * metres.translation - millimetres.translation).norm(), 1e-9);
    }
  }
}

/// A robot of a link `a`, and what follows.
std::string robot(const std::string& more) {
  return "<robot name=\"r\">\n<link name=\"a\"><collision><geometry><box size=\"1 1 1\"/>"
         "</geometry></collision></link>\n" +
         more + "</robot>\n";
}

std::string joint(const std::string& child, const std::string& parent, const std::string& more,
                  const std::string& type = "revolute") {
  return "<link name=\"" + child + "\"/>\n<joint name=\"to " + child + "\" type=\"" + type +
         "\"><parent link=\"" + parent + "\"/><child link=\"" + child + "\"/>" + more +
         "</joint>\n";
}

Result<LoadedMechanism> read(const std::string& text, const std::string& table,
                             const UrdfOptions& options = {}) {
  return readUrdf(writeFile("r.urdf", text), writeFile("t.csv", table), options);
}

TEST(UrdfReader, JointsFollowOthersAndStayAtRest) {
  const auto loaded =
      read(robot(joint("b", "a",
                       "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"0.5\"/>") +
                 joint("c", "a",
                       "<axis xyz=\"1 0 0\"/><mimic joint=\"to b\" multiplier=\"-0.5\" "
                       "offset=\"0.1\"/>",
                       "prismatic") +
                 joint("d", "c", "<mimic joint=\"to c\"/>", "continuous") + joint("e", "a", "")),
           "time,to b,to c\n0,0,9\n1,2,9\n");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_THAT(loaded->notices,
              Contains(HasSubstr("that are fixed or mimic others are not read: 'to c'")));
  const model::Pose c = loaded->mechanism.at(2, 1);
  EXPECT_LE((c.translation - Point3(0.1 - 1, 0, 0)).norm(), 1e-15);
  const model::Pose d = loaded->mechanism.at(3, 1);
  EXPECT_NEAR(d.rotation(2, 1), std::sin(-0.9), 1e-15);
  EXPECT_THAT(loaded->notices, Contains(HasSubstr("has no column for 'to e', which stays at 0")));
  EXPECT_THAT(loaded->notices,
              Contains(HasSubstr("joint 'to b' is beyond its limits, -1 to 1 rad")));
  EXPECT_THAT(loaded->notices, Contains(HasSubstr("moves faster than its limit, 0.5 rad/s, in 1 of "
                                                  "1 steps; the fastest is 2")));
}

TEST(UrdfReader, MeshesAreFoundInPackagesAndScaled) {
  const auto mesh = temporaryPath("part/meshes/t.obj");
  std::filesystem::create_directories(mesh.parent_path());
  writeFile("part/meshes/t.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string moving = joint("b", "a", "");
  for (const char* name : {"package://part/meshes/t.obj", "part/meshes/t.obj"}) {
    const auto loaded = read(
        robot("<link name=\"m\"><visual><geometry><mesh filename=\"" + std::string(name) +
              "\" scale=\"2 2 -2\"/></geometry></visual></link><joint name=\"j\" type=\"fixed\">"
              "<parent link=\"a\"/><child link=\"m\"/></joint>" +
              moving),
        "time,to b\n0,0\n1,2\n", {.geometry = "visual"});
    ASSERT_TRUE(loaded) << loaded.error().text();
    ASSERT_EQ(loaded->solids.size(), 1U);
    EXPECT_NEAR(signedVolume(loaded->solids[0].mesh), 8 / 6.0, 1e-15);
    EXPECT_THAT(loaded->notices,
                Contains(HasSubstr("1 link has no visual geometry and is left out: 'a'")));
  }
}

TEST(UrdfReader, RefusesWithTheLine) {
  const auto error = [&](const std::string& text,
                         const std::string& values = "time,to b\n0,0\n1,1\n") {
    const auto loaded = read(text, values);
    return loaded ? std::string("(was accepted)") : loaded.error().text();
  };
  const std::string b = joint("b", "a", "");
  EXPECT_EQ(error(robot(b)), "(was accepted)");
  EXPECT_THAT(error("<robot>\n<link name='a'>"), HasSubstr("r.urdf:2: is not XML: "));
  EXPECT_THAT(error("<sdf/>"), HasSubstr("r.urdf:1: found the element <sdf>"));
  EXPECT_THAT(error("<robot><xacro:arm/></robot>"), HasSubstr("expand it with xacro"));
  EXPECT_THAT(error("<!DOCTYPE r [<!ENTITY e 'x'>]><robot/>"), HasSubstr("declares an entity"));
  EXPECT_THAT(error(robot(b + "<link name=\"a\"/>")),
              HasSubstr("r.urdf:5: there is a second link 'a'"));
  EXPECT_THAT(error(robot(joint("b", "z", ""))), HasSubstr("r.urdf:4: the parent is 'z'"));
  EXPECT_THAT(error(robot(joint("b", "a", "", "floating"))),
              HasSubstr("r.urdf:4: joint 'to b': the type is 'floating', expected one of fixed"));
  EXPECT_THAT(error(robot(joint("b", "c", "") + joint("c", "b", ""))),
              HasSubstr("hang on each other: 'b', 'c', 'b'"));
  EXPECT_THAT(error(robot(b + "<joint name=\"again\" type=\"fixed\"><parent link=\"a\"/>"
                              "<child link=\"b\"/></joint>")),
              HasSubstr("the child of two joints, 'to b' (line 4) and 'again'"));
  EXPECT_THAT(error(robot(b + "<link name=\"lone\"/>")), HasSubstr("has 2 roots"));
  EXPECT_THAT(error(robot(joint("b", "a", "<limit lower=\"1\" upper=\"-1\"/>"))),
              HasSubstr("r.urdf:4: joint 'to b': lower is 1, above upper, -1"));
  EXPECT_THAT(error(robot(joint("b", "a", "<limit velocity=\"-1\"/>"))),
              HasSubstr("the velocity is -1"));
  EXPECT_THAT(error(robot(joint("b", "a", "<axis xyz=\"0 0 0\"/>"))), HasSubstr("no direction"));
  EXPECT_THAT(error(robot(joint("b", "a", "<axis xyz=\"0 1\"/>"))),
              HasSubstr("xyz of <axis>: found '0 1', expected 3 numbers"));
  EXPECT_THAT(error(robot(joint("b", "a", "<mimic joint=\"to b\"/>"))), HasSubstr("mimics itself"));
  EXPECT_THAT(error(robot(joint("b", "a", "<mimic joint=\"none\"/>"))), HasSubstr("not a joint"));
  EXPECT_THAT(error(robot(b), "time,elbow\n0,0\n1,1\n"),
              HasSubstr("t.csv: the column 'elbow' is not a joint of"));
  EXPECT_THAT(error(robot(b), "time,to b [mm]\n0,0\n1,1\n"), HasSubstr("expected rad or deg"));
  const auto meshed = [&](const std::string& name) {
    return error(robot(b + "<link name=\"m\">\n<collision><geometry><mesh filename=\"" + name +
                       "\"/></geometry></collision></link><joint name=\"j\" type=\"fixed\">"
                       "<parent link=\"a\"/><child link=\"m\"/></joint>"));
  };
  EXPECT_THAT(meshed("none.stl"), HasSubstr("r.urdf:6: "));
  EXPECT_THAT(meshed("package://nowhere/none.stl"),
              HasSubstr("put the package 'nowhere' beside it"));
  EXPECT_THAT(meshed("none.dae"), HasSubstr("no such file"));
}

}  // namespace
}  // namespace t4d::formats
