#include "formats/motion/joint_log.h"

#include <gmock/gmock.h>

#include "formats/motion/joint_table.h"

namespace t4d::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

JointTable tableOf(const std::string& text, const std::set<std::string>& joints = {}) {
  auto table = readJointTable({"log", text}, "s", joints);
  EXPECT_TRUE(table) << table.error().text();
  return table ? std::move(*table) : JointTable();
}

std::string errorOf(const std::string& text) {
  const auto table = readJointTable({"log", text}, "s");
  return table ? "(was accepted)" : table.error().text();
}

/// All forms of one log: the elbow goes from 0.5 to -0.25, the wrist rests at 2, in 1.5 s.
void expectTheLog(const JointTable& table) {
  EXPECT_THAT(table.times, ElementsAre(0, 1.5));
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "elbow");
  EXPECT_THAT(table.columns[0].values, ElementsAre(0.5, -0.25));
  EXPECT_EQ(table.columns[1].name, "wrist");
  EXPECT_THAT(table.columns[1].values, ElementsAre(2, 2));
}

TEST(JointLog, TrajectoriesAndStatesInJsonAreTables) {
  const std::string trajectory =
      R"({"joint_names": ["elbow", "wrist"], "points": [
        {"positions": [0.5, 2], "time_from_start": {"sec": 0, "nanosec": 0}},
        {"positions": [-0.25, 2], "time_from_start": {"secs": 1, "nsecs": 500000000}}]})";
  expectTheLog(tableOf(trajectory));
  expectTheLog(tableOf(R"({"joint_trajectory": )" + trajectory + "}"));
  // As MoveIt publishes it: where it begins, and no poses.
  expectTheLog(tableOf(R"({"start": {"joint_state": {"header": {"stamp": 0}, "name": ["wrist"],
      "position": [7]}}, "joint_trajectory": )" +
                       trajectory +
                       R"(, "multi_dof_joint_trajectory": {"joint_names": [], "points": []}})"));
  const JointTable poses = tableOf(
      R"({"joint_names": ["base"], "points": [
        {"transforms": [{"translation": {"x": 1, "y": 2, "z": 3},
                         "rotation": {"x": 0.5, "y": -0.5, "z": 0.25, "w": 1}}], "time_from_start": 0},
        {"transforms": [{"translation": {"x": 0, "y": 0, "z": 0},
                         "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}], "time_from_start": 1}]})",
      {"base.x", "base.y", "base.z", "base.qx", "base.qy", "base.qz", "base.qw"});
  ASSERT_EQ(poses.columns.size(), 7U);
  EXPECT_THAT(poses.find("base.z").column->values, ElementsAre(3, 0));
  EXPECT_THAT(poses.find("base.qz").column->values, ElementsAre(0.25, 0));
  const std::string first =
      R"({"header": {"stamp": {"sec": 0, "nanosec": 0}}, "name": ["elbow", "wrist"], "position": [0.5, 2]})";
  const std::string second =
      R"({"header": {"stamp": {"sec": 1, "nanosec": 500000000}}, "name": ["elbow", "wrist"], "position": [-0.25, 2]})";
  expectTheLog(tableOf("[" + first + ", {\"message\": " + second + "}]"));
  expectTheLog(tableOf(first + "\n" + second + "\n"));  // a message on each line
  EXPECT_THAT(errorOf("[" + trajectory + "," + trajectory + "]"), HasSubstr("has 2 trajectories"));
  EXPECT_THAT(errorOf(R"({"a": 1})"), HasSubstr("JSON without joints"));
  EXPECT_THAT(errorOf(R"({"joint_names": ["a"], "points": [{"positions": [1]}]})"),
              HasSubstr("time_from_start"));
  EXPECT_THAT(
      errorOf(R"({"joint_names": ["a"], "points": [{"positions": [1, 2], "time_from_start": 0}]})"),
      HasSubstr("different joints"));
}

TEST(JointLog, EchoedStatesAndArraysInCellsAreTables) {
  expectTheLog(tableOf(
      "0,0,base,elbow,wrist,0.5,2.0,0.1,0.1\n1,500000000,base,elbow,wrist,-0.25,2.0,0,0\n"));
  expectTheLog(tableOf("0,0,,elbow,wrist,0.5,2.0\n1,500000000,,elbow,wrist,-0.25,2.0\n"));
  EXPECT_THAT(errorOf("0,0,,elbow,wrist,0.5,2\n1,0,,wrist,elbow,2,0.5\n"),
              HasSubstr("log:2: names other joints"));
  expectTheLog(
      tableOf("time,name,position,effort\n0,\"['elbow', 'wrist']\",\"[0.5, 2.0]\",\"[]\"\n"
              "1.5,\"['elbow', 'wrist']\",\"[-0.25, 2.0]\",\"[]\"\n"));
  const JointTable numbered =
      tableOf("time,q\n0,\"array('d', [0.5, 2.0])\"\n1.5,\"array('d', [-0.25, 2.0])\"\n");
  ASSERT_EQ(numbered.columns.size(), 2U);
  EXPECT_EQ(numbered.columns[1].name, "q_1");
  EXPECT_THAT(numbered.columns[0].values, ElementsAre(0.5, -0.25));
  EXPECT_THAT(errorOf("time,q\n0,\"[1, 2]\"\n1,\"[1]\"\n"), HasSubstr("log:3: has other arrays"));
}

TEST(JointLog, ANameThatIsAskedForWinsOverAPath) {
  const std::string text = "time,joint_0.0,joint_1.0_deg,/other/velocity\n0,1,90,x\n1,2,90,y\n";
  const JointTable table = tableOf(text, {"joint_0.0", "joint_1.0"});
  ASSERT_EQ(table.columns.size(), 2U);
  ASSERT_NE(table.find("joint_0.0").column, nullptr);
  EXPECT_THAT(table.find("joint_0.0").column->values, ElementsAre(1, 2));
  EXPECT_EQ(table.find("joint_1.0").unit, "deg");
  EXPECT_THAT(errorOf(text), HasSubstr("no column is a joint"));
}

}  // namespace
}  // namespace t4d::formats
