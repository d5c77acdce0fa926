#include "formats/motion/motion_csv.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "t4d/motion.h"

namespace t4d::formats {
namespace {

Result<model::Motion> read(const std::string& text) { return readMotionCsv({"p.csv", text}); }

std::string errorOfTable(const std::string& text) {
  const auto motion = read(text);
  return motion ? "(was accepted)" : motion.error().text();
}

/// The motion of the poses in docs/motion.md, whose quaternions are exact here.
model::Motion expected() {
  return *parseMotion(R"({"poses": [{"time": 0}, {"time": 1, "position": [10, 0, 0],
      "quaternion": [0, 0, 0.6, 0.8]}, {"time": 3, "position": [10, 20, 5],
      "quaternion": [0.5, 0.5, 0.5, 0.5]}]})",
                      "expected");
}

void expectSame(const Result<model::Motion>& found, double tolerance) {
  ASSERT_TRUE(found) << found.error().text();
  const model::Motion wanted = expected();
  ASSERT_EQ(found->segments.size(), wanted.segments.size());
  for (std::size_t i = 0; i < wanted.segments.size(); ++i) {
    EXPECT_EQ(found->segments[i].timeEnd, wanted.segments[i].timeEnd);
    for (const double fraction : {0.0, 0.4, 1.0}) {
      EXPECT_LE(
          (found->segments[i].at(fraction).matrix() - wanted.segments[i].at(fraction).matrix())
              .cwiseAbs()
              .maxCoeff(),
          tolerance);
    }
  }
}

TEST(MotionCsv, ColumnsAreFoundByTheirNames) {
  expectSame(read("time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,10,0,0,0,0,0.6,0.8\n"
                  "3,10,20,5,0.5,0.5,0.5,0.5\n"),
             0);
  expectSame(read("# poses\nQW; QX; QY; QZ; px; py; pz; t\r\n1;0;0;0;0;0;0;0\r\n"
                  "0.8;0;0;0.6;10;0;0;1\r\n-.5;-.5;-.5;-.5;10;20;5;3\r\n\r\n"),
             1e-15);
  expectSame(read("\"Time\"\tquat_w\tquat_x\tquat_y\tquat_z\tpos_x\tpos_y\tpos_z\n"
                  "0\t1\t0\t0\t0\t0\t0\t0\n1\t0.8\t0\t0\t0.6\t10\t0\t0\n"
                  "3\t0.5\t0.5\t0.5\t0.5\t10\t20\t5\n"),
             0);
}

TEST(MotionCsv, BlanksSeparateAndACommentMayHaveTheNames) {
  const std::string poses = "0 0 0 0 0 0 0 1\n1.0 10 0 0 0 0 0.6 0.8\n 3  10\t20 5 .5 .5 .5 .5 \n";
  for (const char* names : {"# ground truth\n# file: 'a.bag'\n# timestamp tx ty tz qx qy qz qw\n",
                            "#time,x,y,z,qx,qy,qz,qw\r\n", "t x  y z qx qy qz qw\n"}) {
    std::string form;
    const std::string text = names + poses;
    expectSame(readMotionCsv({"p.txt", text}, &form), 0);
    EXPECT_EQ(form, text[0] == '#' ? "columns are separated by blanks, their names are in a comment"
                                   : "columns are separated by blanks");
  }
}

TEST(MotionCsv, DecimalCommasAreToldByTheNumbers) {
  std::string form;
  const std::string poses =
      "0;0;0;0;0;0;0;1\n1,0;1,0e1;0;0;0;0;0,6;0,8\n3;10,000;20;5;0,5;0,5;0,5;0,5\n";
  expectSame(readMotionCsv({"p.csv", "time;x;y;z;qx;qy;qz;qw\n" + poses}, &form), 0);
  EXPECT_EQ(form, "numbers have decimal commas");
  expectSame(readMotionCsv({"p.csv", "# time;x;y;z;qx;qy;qz;qw\n" + poses}, &form), 0);
  EXPECT_EQ(form, "their names are in a comment, numbers have decimal commas");
  std::string tabs = poses;
  std::ranges::replace(tabs, ';', '\t');
  expectSame(read("time\tx\ty\tz\tqx\tqy\tqz\tqw\n" + tabs), 0);
}

TEST(MotionCsv, MatricesArePoses) {
  const std::string rows[] = {"1,0,0,0,0,1,0,0,0,0,1,0", "0.28,-0.96,0,10,0.96,0.28,0,0,0,0,1,0",
                              "0,0,1,10,1,0,0,20,0,1,0,5"};
  const std::string times[] = {"0", "1", "3"};
  for (const int first : {0, 1}) {
    for (const int height : {3, 4}) {
      std::string table = "time";
      for (int i = 0; i < 4 * height; ++i) {
        table += ",m" + std::to_string(i / 4 + first) + std::to_string(i % 4 + first);
      }
      for (int i = 0; i < 3; ++i) {
        table += "\n" + times[i] + "," + rows[i] + (height == 4 ? ",0,0,0,1" : "");
      }
      expectSame(read(table), 1e-14);
    }
  }
}

TEST(MotionCsv, HalfTurnsAreListedWithTheirLines) {
  const auto turns = read(
      "# a comment\n# t qx qy qz qw\n0 0 0 0 1\n1 0 0 1 0\n\n2 0 0 0 -1\n"
      "3 0 0.7071 0 0.7071\n4 0.7071 0 -0.7071 -0.0001\n");
  ASSERT_TRUE(turns) << turns.error().text();
  ASSERT_EQ(turns->halfTurns.size(), 3U);
  EXPECT_EQ(turns->halfTurns[0].between, "lines 3 and 4");
  EXPECT_EQ(turns->halfTurns[1].between, "lines 4 and 6");
  EXPECT_EQ(turns->halfTurns[2].between, "lines 7 and 8");
  EXPECT_EQ(model::noticeOfHalfTurns(turns->halfTurns),
            "3 pairs of poses, the first lines 3 and 4, are half a turn apart, so the direction of "
            "the turn is not known: from time 0 to 1 it is taken right-handed about (0, 0, 1). Add "
            "a pose in between to choose it");
  const auto json = parseMotion(R"({"poses": [{"time": 0}, {"time": 1, "quaternion": [1, 0, 0, 0]},
      {"time": 2}]})",
                                "a.json");
  ASSERT_TRUE(json);
  ASSERT_EQ(json->halfTurns.size(), 2U);
  EXPECT_EQ(json->halfTurns[1].between, "poses[1] and poses[2]");
}

TEST(MotionCsv, PositionsOrRotationsAloneAreEnough) {
  const auto moved = read("t,x,y,z\n0,0,0,0\n2,1,2,3\n");
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->segments[0].screw.angleDegrees, 0);
  EXPECT_EQ(moved->segments[0].screw.translation, Eigen::Vector3d(1, 2, 3));
  const auto turned = read("t,qw,qx,qy,qz\n0,1,0,0,0\n2,0.7071,0,0,0.7071\n");
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->segments[0].screw.angleDegrees, 90, 1e-12);
}

TEST(MotionCsv, WhatIsNoTableOfPosesIsRefused) {
  const std::string header = "time,x,y,z\n";
  EXPECT_EQ(errorOfTable("time,x,y,z,speed\n0,0,0,0,0\n").substr(0, 41),
            "p.csv:1: the column 'speed' is unknown; k");
  EXPECT_EQ(errorOfTable("time,x,tx,y,z\n"),
            "p.csv:1: the column 'tx' holds the same number of a pose as the column 'x'");
  EXPECT_EQ(errorOfTable("x,y,z\n"),
            "p.csv:1: the column of the time is missing (time, t or timestamp, also with a unit as "
            "time_ms or time [ms], or secs and nsecs); the columns are x, y, z");
  EXPECT_EQ(errorOfTable("time,x,y\n"),
            "p.csv:1: the column z is missing; the columns are time, x, y");
  EXPECT_EQ(errorOfTable("time,qx,qz\n"),
            "p.csv:1: the columns qy, qw are missing; the columns are time, qx, qz");
  EXPECT_TRUE(errorOfTable("0,0,0,0\n").starts_with("p.csv:1: found 4 numbers, expected a "));
  EXPECT_TRUE(
      errorOfTable("time:x:y:z\n").find("separated by commas, semicolons, tabs or blanks") !=
      std::string::npos);
  EXPECT_EQ(errorOfTable("t;x;y;z\n0;0,5;0.5;0\n"),
            "p.csv:2: found '0,5' and '0.5': numbers have a decimal comma or a decimal point, not "
            "both");
  EXPECT_EQ(
      errorOfTable("t;x;y;z\n0;0;0;0\n1;1,500;0;0\n"),
      "p.csv:3: found '1,500', whose comma may be a decimal comma or stand between thousands; "
      "write decimal points");
  EXPECT_EQ(errorOfTable("t;x;y;z\n0;0,5;1,234,567;0\n"),
            "p.csv:2: column y: found '1,234,567', expected a number");
  EXPECT_TRUE(errorOfTable("# a trajectory\n0,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n")
                  .starts_with("p.csv:2: found 8 numbers, expected a first line with"));
  for (const char* columns : {"time\n", "time,m00,m01\n", "time,qw,qx,qy,qz,m00\n"}) {
    EXPECT_TRUE(errorOfTable(columns).starts_with("p.csv:1: the columns are ")) << columns;
  }
  EXPECT_EQ(errorOfTable(header + "0,0,0\n"), "p.csv:2: has 3 fields, but 4 columns are named");
  EXPECT_EQ(errorOfTable(header + "\n0,0,zero,0\n"),
            "p.csv:3: column y: found 'zero', expected a number");
  EXPECT_EQ(errorOfTable(header + "0,,0,0\n"), "p.csv:2: column x: found '', expected a number");
  EXPECT_EQ(errorOfTable(header + "0,0,0,0\n"),
            "p.csv: the motion has 1 poses; at least two are needed");
  EXPECT_NE(errorOfTable(header + "1,0,0,0\n0.5,0,0,0\n").find("is at time 0.5, not after line 2"),
            std::string::npos);
  EXPECT_NE(errorOfTable(header + "0,0,0,0\n1,nan,0,0\n").find("not finite"), std::string::npos);
  EXPECT_EQ(errorOfTable("t,qw,qx,qy,qz\n0,1,0,0,0\n1,0,0,0,2\n"),
            "p.csv:3: a quaternion of length 2, expected 1");
  const std::string matrix = "t,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n";
  EXPECT_NE(errorOfTable(matrix + "0,-1,0,0,0,0,1,0,0,0,0,1,0\n").find("mirrors"),
            std::string::npos);
  EXPECT_NE(errorOfTable(matrix + "0,2,0,0,0,0,2,0,0,0,0,2,0\n").find("scales"), std::string::npos);
}

Result<model::Motion> readTable(const std::string& text, const MotionTableOptions& options,
                                std::string* form = nullptr) {
  return readMotionCsv({"p.csv", text}, form, options);
}

/// Whether two motions have the same poses at their times.
void expectSamePoses(const Result<model::Motion>& found, const Result<model::Motion>& wanted) {
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_TRUE(wanted) << wanted.error().text();
  ASSERT_EQ(found->segments.size(), wanted->segments.size());
  for (std::size_t i = 0; i < wanted->segments.size(); ++i) {
    EXPECT_NEAR(found->segments[i].timeEnd, wanted->segments[i].timeEnd, 1e-12);
    EXPECT_LE(
        (found->segments[i].end.matrix() - wanted->segments[i].end.matrix()).cwiseAbs().maxCoeff(),
        1e-12);
  }
}

TEST(MotionCsv, RollPitchYawTurnAboutFixedAxes) {
  // About x, then y, then z, each by a quarter turn: x goes to z, y to y and z to -x.
  const auto wanted = read(
      "t,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n0,1,0,0,0,0,1,0,0,0,0,1,0\n"
      "1,0,0,1,1,0,1,0,2,-1,0,0,3\n");
  const std::string numbers = "\n0,0,0,0,0,0,0\n1,1,2,3,90,90,90\n";
  const std::string radians =
      "\n0,0,0,0,0,0,0\n1,1,2,3,1.5707963267948966,1.5707963267948966,1.5707963267948966\n";
  expectSamePoses(read("t,x,y,z,roll_deg,pitch_deg,yaw_deg" + numbers), wanted);
  expectSamePoses(read("t,x,y,z,roll [rad],pitch [rad],yaw [rad]" + radians), wanted);
  expectSamePoses(readTable("t,x,y,z,roll,pitch,yaw" + numbers, {.angles = "rpy:deg"}), wanted);
  expectSamePoses(readTable("t,x,y,z,rx,ry,rz" + radians, {.angles = "rpy:rad"}), wanted);
  expectSamePoses(readTable("0,0,0,0,0,0,0\n1,1,2,3,90,90,90\n", {.angles = "rpy:deg"}), wanted);
  EXPECT_EQ(errorOfTable("t,roll,pitch,yaw\n0,0,0,0\n"),
            "p.csv:1: nothing says whether roll, pitch and yaw are in degrees or radians: name the "
            "columns roll_deg or roll_rad and so on, or state `angles`, rpy:deg or rpy:rad");
  EXPECT_NE(errorOfTable("t,roll_deg,pitch_rad,yaw_deg\n0,0,0,0\n").find("different units"),
            std::string::npos);
}

TEST(MotionCsv, RotationVectorsAreAxisTimesAngle) {
  const auto wanted =
      read("t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0.7071067811865476,0.7071067811865476\n");
  std::string form;
  expectSamePoses(readTable("t,rx,ry,rz\n0,0,0,0\n1,0,0,1.5707963267948966\n", {}, &form), wanted);
  EXPECT_EQ(form, "rx ry rz are rotation vectors in radians");
  expectSamePoses(readTable("t,rx,ry,rz\n0,0,0,0\n1,0,0,90\n", {.angles = "rotvec:deg"}), wanted);
  EXPECT_NE(errorOfTable("t,rx,ry,rz\n0,0,0,0\n1,0,0,90\n").find("a rotation vector of 90 radians"),
            std::string::npos);
  EXPECT_NE(errorOfTable("t,rx_deg,ry_deg,rz_deg\n0,0,0,0\n").find("rotvec:deg or rpy:deg"),
            std::string::npos);
}

TEST(MotionCsv, TheOrderOfQuaternionsIsStatedOrNamed) {
  const auto wanted = read("t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0.6,0.8\n");
  expectSamePoses(read("t,q_w,q_x,q_y,q_z\n0,1,0,0,0\n1,0.8,0,0,0.6\n"), wanted);
  const std::string scalarFirst = "\n0,1,0,0,0\n1,0.8,0,0,0.6\n";
  expectSamePoses(readTable("t,q0,q1,q2,q3" + scalarFirst, {.quaternion = "wxyz"}), wanted);
  expectSamePoses(readTable("t,q1,q2,q3,q4" + scalarFirst, {.quaternion = "wxyz"}), wanted);
  expectSamePoses(readTable("t,q1,q2,q3,q4\n0,0,0,0,1\n1,0,0,0.6,0.8\n", {.quaternion = "xyzw"}),
                  wanted);
  EXPECT_NE(errorOfTable("t,q1,q2,q3,q4" + scalarFirst).find("do not say which is w"),
            std::string::npos);
  std::string form;
  expectSamePoses(readTable("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0.6 0.8\n", {}, &form), wanted);
  EXPECT_EQ(form,
            "columns are separated by blanks, no names of columns: read as time x y z qx qy qz qw");
  expectSamePoses(readTable("0,0,0,0,1,0,0,0\n1,0,0,0,0.8,0,0,0.6\n", {.quaternion = "wxyz"}),
                  wanted);
  for (const MotionTableOptions& options :
       {MotionTableOptions{.angles = "rpy:deg"}, MotionTableOptions{.quaternion = "wxyz"}}) {
    const auto refused = readTable("t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0.6,0.8\n", options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Options);
  }
}

TEST(MotionCsv, LogsOfRobotsAreReadByTheirNames) {
  const auto wanted = read("t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.5,1,2,3,0,0,0.6,0.8\n");
  const std::string pose =
      ",field.pose.position.x,field.pose.position.y,field.pose.position.z,"
      "field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
      "field.pose.orientation.w\n";
  std::string form;
  auto ros = readTable(
      "%time,field.header.seq,field.header.frame_id" + pose +
          "1700000000000000000,1,map,0,0,0,0,0,0,1\n1700000000500000000,2,map,1,2,3,0,0,0.6,0.8\n",
      {}, &form);
  ASSERT_TRUE(ros) << ros.error().text();
  EXPECT_EQ(ros->timeUnit, "s");
  EXPECT_EQ(ros->timeBegin(), 1.7e9);
  EXPECT_EQ(ros->timeEnd(), 1.7e9 + 0.5);
  EXPECT_EQ(form, "columns that are not read: 'field.header.seq' 'field.header.frame_id'");
  const auto stamps = read(
      "header.stamp.secs,header.stamp.nsecs,position.x,position.y,position.z,orientation.x,"
      "orientation.y,orientation.z,orientation.w\n7,250000000,0,0,0,0,0,0,1\n"
      "8,0,1,2,3,0,0,0.6,0.8\n");
  ASSERT_TRUE(stamps) << stamps.error().text();
  EXPECT_EQ(stamps->timeBegin(), 7.25);
  EXPECT_EQ(stamps->timeEnd(), 8);
  expectSamePoses(read("__time,/tool/pose/position/x,/tool/pose/position/y,/tool/pose/position/z,"
                       "/tool/pose/orientation/x,/tool/pose/orientation/y,/tool/pose/orientation/z,"
                       "/tool/pose/orientation/w\n0,0,0,0,0,0,0,1\n0.5,1,2,3,0,0,0.6,0.8\n"),
                  wanted);
}

TEST(MotionCsv, UnitsAreThoseOfColumnsAndConverted) {
  const std::string rows = "\n0,0,0,0\n500,1,2,3\n";
  const auto named = read("time_ms,x [m],y [m],z [m]" + rows);
  ASSERT_TRUE(named);
  EXPECT_EQ(named->timeUnit, "ms");
  EXPECT_EQ(named->lengthUnit, "m");
  const auto converted =
      readTable("time_ms,x_m,y_m,z_m" + rows, {.lengthUnit = "mm", .timeUnit = "s"});
  ASSERT_TRUE(converted);
  EXPECT_EQ(converted->timeUnit, "s");
  EXPECT_EQ(converted->lengthUnit, "mm");
  EXPECT_EQ(converted->timeEnd(), 0.5);
  EXPECT_EQ(converted->segments[0].end.translation, Eigen::Vector3d(1000, 2000, 3000));
  const auto stated = readTable("time,x,y,z" + rows, {.lengthUnit = "in", .timeUnit = "ms"});
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->timeEnd(), 500);
  EXPECT_EQ(stated->lengthUnit, "in");
  EXPECT_NE(errorOfTable("t,x_m,y_mm,z_m" + rows).find("different units"), std::string::npos);
  // Other names of units are kept, and not converted.
  const auto frames = read("t [frames],x,y,z" + rows);
  ASSERT_TRUE(frames);
  EXPECT_EQ(frames->timeUnit, "frames");
  const auto seconds = readTable("t [frames],x,y,z" + rows, {.timeUnit = "s"});
  ASSERT_FALSE(seconds);
  EXPECT_NE(seconds.error().text().find("'frames', which cannot be converted to 's'"),
            std::string::npos);
  const auto metres = readTable("t,x [au],y [au],z [au]" + rows, {.lengthUnit = "m"});
  ASSERT_FALSE(metres);
  EXPECT_NE(metres.error().text().find("known units are"), std::string::npos);
}

TEST(MotionCsv, RowsThatRepeatAreMergedOrRefused) {
  std::string form;
  const auto merged =
      readTable("t,x,y,z\n0,0,0,0\n0,0,0,0\n1,1,0,0\n1.0,1,0,0\n1,1.0,0,0\n2,0,0,0\n", {}, &form);
  ASSERT_TRUE(merged) << merged.error().text();
  EXPECT_EQ(merged->segments.size(), 2U);
  EXPECT_EQ(form, "3 lines repeat the one before and are left out, the first line 3");
  EXPECT_EQ(errorOfTable("t,x,y,z\n0,0,0,0\n1,1,0,0\n1,2,0,0\n"),
            "p.csv:4: is at time 1, as line 3, with other values: keep one of the two");
}

TEST(MotionCsv, DamagedTablesAreReadOrRefused) {
  const std::string table =
      "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,10,0,0,0,0,0.6,0.8\n3,1,2,5,0.5,0.5,0.5,0.5\n";
  const auto judge = [](const std::string& text) {
    const auto motion = read(text);
    if (motion) {
      EXPECT_FALSE(motion->segments.empty());
    } else {
      EXPECT_TRUE(motion.error().where.file.starts_with("p.csv"));
    }
  };
  for (std::size_t size = 0; size < table.size(); ++size) judge(table.substr(0, size));
  std::mt19937 random(1);
  const std::string telling = "0123456789+-.eE,;\t\n\r\"#xyzqm \xff" + std::string(1, '\0');
  for (std::size_t at = 0; at < table.size(); ++at) {
    for (int round = 0; round < 8; ++round) {
      std::string damaged = table;
      damaged[at] = telling[random() % telling.size()];
      judge(damaged);
    }
  }
}

}  // namespace
}  // namespace t4d::formats
