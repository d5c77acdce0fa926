#include "formats/motion/urdf_reader.h"

#include <cstdlib>
#include <numbers>

#include <fmt/format.h>
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
  EXPECT_THAT(
      loaded->notices,
      Contains(HasSubstr(
          "that are fixed, mimic others or have several values (NAME.x) are not read: 'to c'")));
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

TEST(UrdfReader, PackagesAreFoundByDescriptionEnvironmentAndName) {
  const std::string solid =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (const char* folder : {"clone/robot", "elsewhere/share/hand/meshes", "tree/foot", "loose"}) {
    std::filesystem::create_directories(temporaryPath(folder));
  }
  // A clone of another name, with a description; an installed one; one of a workspace.
  writeFile("clone/package.xml",
            "<package>\n<name> arm </name>\n<depend>hand</depend>\n</package>");
  writeFile("clone/arm.obj", solid);
  writeFile("elsewhere/share/hand/meshes/hand.obj", solid);
  writeFile("tree/foot/foot.obj", solid);
  writeFile("loose/nose.obj", solid);
  const std::string table = writeFile("moves.csv", "time,to b\n0,0\n1,2\n").string();
  const auto found = [&](const std::string& mesh, const Packages& packages = {}) {
    const std::string text =
        robot("<link name=\"m\"><collision><geometry><mesh filename=\"" + mesh +
              "\"/></geometry></collision></link><joint name=\"j\" type=\"fixed\">"
              "<parent link=\"a\"/><child link=\"m\"/></joint>" +
              joint("b", "a", ""));
    UrdfOptions options;
    options.packages = packages;
    return static_cast<bool>(readUrdf(writeFile("clone/robot/r.urdf", text), table, options));
  };
  EXPECT_TRUE(found("package://arm/arm.obj"));
  EXPECT_FALSE(found("package://hand/arm.obj"));
  EXPECT_TRUE(found("package:///clone/arm.obj"));
  EXPECT_FALSE(found("package://hand/meshes/hand.obj"));
  ::setenv("AMENT_PREFIX_PATH", ("/nowhere:" + temporaryPath("elsewhere").string()).c_str(), 1);
  EXPECT_TRUE(found("package://hand/meshes/hand.obj"));
  ::unsetenv("AMENT_PREFIX_PATH");
  EXPECT_FALSE(found("package://foot/foot.obj"));
  ::setenv("ROS_PACKAGE_PATH", temporaryPath("tree").c_str(), 1);
  EXPECT_TRUE(found("package://foot/foot.obj"));
  ::setenv("ROS_PACKAGE_PATH", temporaryPath("tree/foot").c_str(), 1);
  EXPECT_TRUE(found("package://foot/foot.obj"));
  ::unsetenv("ROS_PACKAGE_PATH");
  EXPECT_TRUE(found("package://face/nose.obj", {{"face", temporaryPath("loose")}}));
  EXPECT_FALSE(found("package://arm/arm.obj", {{"arm", temporaryPath("loose")}}));
}

TEST(UrdfReader, CapsulesRestingJointsAndRobotsWithoutCollisionGeometry) {
  const std::string capsule = "<geometry><capsule radius=\"0.5\" length=\"2\"/></geometry>";
  const auto loaded = read("<robot name=\"r\"><link name=\"a\"><visual>" + capsule +
                               "</visual></link>\n" + joint("f", "a", "", "floating") +
                               joint("p", "f", "", "planar") + joint("b", "p", "") + "</robot>",
                           "time,to b\n0,0\n1,2\n");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_THAT(loaded->notices, Contains(HasSubstr("the visual geometry is taken")));
  EXPECT_THAT(loaded->notices,
              Contains(HasSubstr("has no column for 'to f', 'to p', which stay at 0")));
  // A cylinder and a sphere, inscribed: within 0.3 %.
  const double volume = signedVolume(loaded->solids[0].mesh);
  const double whole = std::numbers::pi * (0.25 * 2 + 4.0 / 3 * 0.125);
  EXPECT_LT(volume, whole);
  EXPECT_NEAR(volume, whole, 0.004 * whole);
  model::Bounds3 bounds = boundsOf(loaded->solids[0].mesh);
  EXPECT_EQ(bounds.max.z(), 1.5);
  EXPECT_EQ(bounds.min.z(), -1.5);
}

// As public robots have them, and other programs accept them.
TEST(UrdfReader, LimitsThatCannotBeKeptAndLeadersThatAreMissingAreNoted) {
  const auto loaded = read(robot(joint("b", "a",
                                       "<axis xyz=\"0 0 1\"/><limit lower=\"1\" upper=\"-1\"/>"
                                       "<mimic joint=\"none\" offset=\"3\"/>")),
                           "time,to b\n0,0\n1,2\n");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_THAT(loaded->notices,
              testing::UnorderedElementsAre(
                  HasSubstr("joint 'to b': its lower limit is 1, above the upper one, -1"),
                  HasSubstr("joint 'to b' mimics 'none', which is not a joint")));
  EXPECT_NEAR(loaded->mechanism.at(1, 1).rotation(1, 0), std::sin(2), 1e-15);
}

// On x = 1: evenly by (2, 3) along a straight line while it turns by 6, nearly a whole turn.
TEST(UrdfReader, PlanarJointsSlideAndTurnEvenly) {
  const std::string place = "<origin xyz=\"1 0 0\"/>";
  const std::string arm =
      robot(joint("p", "a", place + "<axis xyz=\"0 0 1\"/>", "planar") + joint("b", "p", ""));
  for (const char* columns : {"to p.x,to p.y,to p.angle,to b", "to p/x,to p/y,to p/theta,to b",
                              "to p_x [mm],to p_y [mm],to p_angle [deg],to b", "q_0,q_1,q_2,q_3"}) {
    const bool converted = std::string(columns).find("mm") != std::string::npos;
    const auto loaded = read(
        arm, fmt::format("time,{}\n0,0,0,0,0\n1,{},{},{:.17g},0\n", columns, converted ? 2000 : 2,
                         converted ? 3000 : 3, converted ? 1080 / std::numbers::pi : 6));
    ASSERT_TRUE(loaded) << loaded.error().text();
    ASSERT_EQ(loaded->mechanism.links[3].name, "p");
    ASSERT_EQ(loaded->joints.size(), 4U);
    EXPECT_EQ(loaded->joints[2].name, "to p.angle");
    for (const double t : {0.0, 0.25, 0.5, 1.0}) {
      const model::Pose moved = loaded->mechanism.at(3, t);
      EXPECT_LE((moved(Point3(1, 0, 0)) - Point3(1 + 2 * t, 3 * t, 0)).norm(), 1e-14);
      EXPECT_NEAR(moved.rotation(1, 0), std::sin(6 * t), 1e-14);
      EXPECT_NEAR(moved.rotation(0, 0), std::cos(6 * t), 1e-14);
    }
  }
  // Without an <axis> it is x, by URDF: about it, z becomes x and x becomes -z.
  const auto upright = read(robot(joint("p", "a", place, "planar")),
                            "time,to p.x,to p.y,to p.angle\n0,0,0,0\n1,2,3,0.5\n");
  ASSERT_TRUE(upright) << upright.error().text();
  EXPECT_THAT(upright->notices, Contains(HasSubstr("is planar about (1, 0, 0)")));
  EXPECT_THAT(upright->notices,
              Contains(HasSubstr("x goes along (0, 0, -1) and y along (0, 1, 0)")));
  const model::Pose moved = upright->mechanism.at(3, 1);
  EXPECT_LE((moved(Point3(1, 0, 0)) - Point3(1, 3, -2)).norm(), 1e-14);
  EXPECT_NEAR(moved.rotation(2, 1), std::sin(0.5), 1e-14);
}

// From the identity by a quarter turn about z to (1, 1, 0): a screw about (0, 1).
TEST(UrdfReader, FloatingJointsAreAtTheirPosesAndMoveByScrews) {
  const std::string values =
      "0,0,0,0,0,0,0,1\n1,1,1,0,0,0,0.70710678118654757,0.70710678118654757\n"
      "2,1,2,3,0.5,-0.5,0.1,0.7\n";
  const std::string place = "<origin xyz=\"1 2 3\" rpy=\"0.3 -0.2 0.9\"/>";
  using Eigen::AngleAxisd;
  const model::Pose rest{(AngleAxisd(0.9, Point3::UnitZ()) * AngleAxisd(-0.2, Point3::UnitY()) *
                          AngleAxisd(0.3, Point3::UnitX()))
                             .toRotationMatrix(),
                         Point3(1, 2, 3)};
  const auto turned = [](double angle) {
    return AngleAxisd(angle, Point3::UnitZ()).toRotationMatrix();
  };
  const double half = std::sqrt(0.5);
  const std::vector<std::pair<double, model::Pose>> wanted = {
      {0, {}},
      {0.5, {turned(std::numbers::pi / 4), Point3(half, 1 - half, 0)}},
      {1, {turned(std::numbers::pi / 2), Point3(1, 1, 0)}},
      {2, {Eigen::Quaterniond(0.7, 0.5, -0.5, 0.1).toRotationMatrix(), Point3(1, 2, 3)}}};
  const std::string arm = robot(joint("f", "a", place, "floating"));
  for (const char* columns :
       {"to f.x,to f.y,to f.z,to f.qx,to f.qy,to f.qz,to f.qw",
        "to f/trans_x,to f/trans_y,to f/trans_z,to f/rot_x,to f/rot_y,to f/rot_z,to f/rot_w",
        "q_0,q_1,q_2,q_3,q_4,q_5,q_6"}) {
    const auto loaded = read(arm, fmt::format("time,{}\n{}", columns, values));
    ASSERT_TRUE(loaded) << loaded.error().text();
    for (const auto& [time, pose] : wanted) {
      const model::Pose found = loaded->mechanism.at(1, time) * rest;
      EXPECT_LE((found.matrix() - (rest * pose).matrix()).cwiseAbs().maxCoeff(), 1e-14) << time;
    }
  }
}

// A controller logs joints by number, from the root on (RTDE).
TEST(UrdfReader, NumberedColumnsAreTheJointsFromTheRootOn) {
  const std::string arm =
      robot(joint("z", "a", "") + joint("c", "z", "", "fixed") + joint("b", "c", ""));
  const auto loaded = read(
      arm, "timestamp actual_q_0 actual_q_1 actual_qd_0 actual_qd_1\n0 0.5 1 9 9\n1 0.75 2 9 9\n");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_THAT(loaded->notices,
              Contains(HasSubstr("actual_q_0 to actual_q_1 are taken as to z, to b")));
  ASSERT_EQ(loaded->joints.size(), 2U);
  EXPECT_EQ(loaded->joints[0].name, "to z");
  EXPECT_EQ(loaded->joints[0].at(0.5), 0.625);
  EXPECT_EQ(loaded->joints[1].at(7), 2);
  EXPECT_FALSE(read(arm, "time,q_0,q_1,q_2\n0,0,0,0\n1,1,1,1\n"));  // one too many
}

// Turned by a quarter about z and moved, in millimetres; on a carriage that moves by 10 in all.
TEST(UrdfReader, RobotsInAMechanismMoveAsByThemselvesWhereTheyStand) {
  const auto alone = readUrdf(fixtureNamed("arm.urdf"), fixtureNamed("arm-joints.csv"));
  ASSERT_TRUE(alone) << alone.error().text();
  const std::string place =
      R"("position": [100, 200, 300], "quaternion": [0, 0, 0.70710678118654757, 0.70710678118654757])";
  const std::string robot = R"({"robot": "arm.urdf", "motion": "arm-joints.csv", )" + place;
  const auto both = readMechanism(writeFile("cell.json", R"({"length_unit": "mm", "bodies": [
      {"name": "carriage", "joint": {"type": "prismatic", "axis": [0, 0, 1]},
       "motion": {"times": [0, 4], "values": [0, 10]}}],
      "robots": [)" + robot + R"(, "name": "left"}, )" + robot +
                                                             R"(, "parent": "carriage"}]})"));
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_EQ(both->up, "z");
  EXPECT_EQ(both->timeUnit, "s");
  ASSERT_EQ(both->solids.size(), 2 * alone->solids.size());
  EXPECT_EQ(both->solids[0].name, "left world");
  EXPECT_EQ(both->joints.size(), 1 + 2 * alone->joints.size());
  const Eigen::AngleAxisd quarter(std::numbers::pi / 2, Point3::UnitZ());
  for (std::size_t i = 0; i < both->solids.size(); ++i) {
    const bool carried = i >= alone->solids.size();
    const MechanismSolid& own = alone->solids[i % alone->solids.size()];
    const MechanismSolid& placed = both->solids[i];
    for (const double t : {0.0, 0.4, 2.9, 4.0}) {
      const model::Pose from = alone->mechanism.at(own.link, t) * own.place;
      const model::Pose to = both->mechanism.at(placed.link, t) * placed.place;
      for (std::size_t k = 0; k < own.mesh.vertices.size(); k += 7) {
        const Point3 wanted =
            1000 * (quarter * (from.rotation * own.mesh.vertices[k] + from.translation)) +
            Point3(100, 200, 300 + (carried ? 10 * t / 4 : 0));
        EXPECT_LE((to.rotation * placed.mesh.vertices[k] + to.translation - wanted).norm(), 1e-9);
      }
    }
  }
  const auto error = [](const std::string& robots) {
    const auto loaded = readMechanism(writeFile("cell.json", R"({"robots": [)" + robots + "]}"));
    return loaded ? std::string("(was accepted)") : loaded.error().text();
  };
  EXPECT_EQ(error(robot + "}"), "(was accepted)");
  EXPECT_THAT(error(robot + "}, " + robot + "}"), HasSubstr("robots[1]: has a link 'world'"));
  EXPECT_THAT(error(robot + R"(, "parent": "cart"})"), HasSubstr("is 'cart', which is not a body"));
  EXPECT_THAT(error(R"({"robot": "arm.urdf"})"), HasSubstr("lacks the key 'motion'"));
  EXPECT_THAT(error(""), HasSubstr("bodies"));
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
  EXPECT_THAT(error("<robot><xacro:arm/></robot>"),
              HasSubstr("expand it first: xacro r.urdf > robot.urdf"));
  EXPECT_THAT(error("<!DOCTYPE r [<!ENTITY e 'x'>]><robot/>"), HasSubstr("declares an entity"));
  EXPECT_THAT(error(robot(b + "<link name=\"a\"/>")),
              HasSubstr("r.urdf:5: there is a second link 'a'"));
  EXPECT_THAT(error(robot(joint("b", "z", ""))), HasSubstr("r.urdf:4: the parent is 'z'"));
  EXPECT_THAT(error(robot(joint("b", "a", "", "ball"))),
              HasSubstr("r.urdf:4: joint 'to b': the type is 'ball', expected one of fixed"));
  EXPECT_THAT(error(robot(joint("b", "a", "<origin xyz=\"${x} 0 0\"/>"))),
              HasSubstr("xacro r.urdf > robot.urdf"));
  EXPECT_THAT(
      error(robot("<link name=\"m\"><collision><geometry><mesh filename=\"package:///no/"
                  "where/a-name-that-is-longer-than-any-quote.stl\"/></geometry></collision>"
                  "</link><joint name=\"j\" type=\"fixed\"><parent link=\"a\"/>"
                  "<child link=\"m\"/></joint>" +
                  b)),
      HasSubstr("package:///no/where/a-name-that-is-longer-than-any-quote.stl was not found"));
  EXPECT_THAT(error(robot(joint("b", "c", "") + joint("c", "b", ""))),
              HasSubstr("hang on each other: 'b', 'c', 'b'"));
  EXPECT_THAT(error(robot(b + "<joint name=\"again\" type=\"fixed\"><parent link=\"a\"/>"
                              "<child link=\"b\"/></joint>")),
              HasSubstr("the child of two joints, 'to b' (line 4) and 'again'"));
  EXPECT_THAT(error(robot(b + "<link name=\"lone\"/>")), HasSubstr("has 2 roots"));
  EXPECT_THAT(error(robot(joint("b", "a", "<limit velocity=\"-1\"/>"))),
              HasSubstr("the velocity is -1"));
  EXPECT_THAT(error(robot(joint("b", "a", "<axis xyz=\"0 0 0\"/>"))), HasSubstr("no direction"));
  EXPECT_THAT(error(robot(joint("b", "a", "<axis xyz=\"0 1\"/>"))),
              HasSubstr("xyz of <axis>: found '0 1', expected 3 numbers"));
  EXPECT_THAT(error(robot(joint("b", "a", "<mimic joint=\"to b\"/>"))), HasSubstr("mimics itself"));
  EXPECT_THAT(error(robot(b), "time,elbow\n0,0\n1,1\n"),
              HasSubstr("t.csv: the column 'elbow' is not a joint of"));
  EXPECT_THAT(error(robot(b), "time,to b [mm]\n0,0\n1,1\n"), HasSubstr("expected rad or deg"));
  const std::string floating = robot(joint("f", "a", "", "floating"));
  EXPECT_THAT(error(floating, "time,to f.x,to f.y,to f.z\n0,0,0,0\n1,1,1,1\n"),
              HasSubstr("t.csv: has no column for 'to f.qx', 'to f.qy', 'to f.qz', 'to f.qw', but "
                        "for other values of the floating joint 'to f'; expected all of them"));
  const std::string values = "to f.x,to f.y,to f.z,to f.qx,to f.qy,to f.qz,to f.qw";
  EXPECT_THAT(error(floating, "time," + values + "\n0,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,2\n"),
              HasSubstr("r.urdf:4: joint 'to f': has a quaternion of length 2 at time 1"));
  EXPECT_THAT(error(floating, "time," + values + "_deg\n0,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n"),
              HasSubstr("the column of 'to f.qw' is in 'deg', expected no unit"));
  EXPECT_THAT(error(floating, "time,elbow\n0,0\n1,1\n"), HasSubstr("its joints are 'to f.x', "));
  const auto meshed = [&](const std::string& name) {
    return error(robot(b + "<link name=\"m\">\n<collision><geometry><mesh filename=\"" + name +
                       "\"/></geometry></collision></link><joint name=\"j\" type=\"fixed\">"
                       "<parent link=\"a\"/><child link=\"m\"/></joint>"));
  };
  EXPECT_THAT(meshed("none.stl"), HasSubstr("r.urdf:6: "));
  EXPECT_THAT(meshed("package://nowhere/none.stl"),
              HasSubstr("say where the package is (--package nowhere=FOLDER)"));
  EXPECT_THAT(meshed("none.dae"), HasSubstr("no such file"));
  writeFile("there.dae", "<COLLADA/>");
  EXPECT_THAT(meshed("there.dae"), HasSubstr("Python reads it: python3 -m t4d sweep"));
}

}  // namespace
}  // namespace t4d::formats
