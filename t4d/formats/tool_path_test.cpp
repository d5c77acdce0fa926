#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "t4d/formats/cutter_location_reader.h"
#include "t4d/formats/gcode_reader.h"

namespace t4d::formats {
namespace {

using model::Point3;

Result<ToolPath> gcode(const std::string& text, const ToolPathOptions& options = {}) {
  return readGcode(InputFile{"a.nc", text}, options);
}
Result<ToolPath> locations(const std::string& text) {
  return readCutterLocations(InputFile{"a.cl", text});
}
std::string refusalOf(const Result<ToolPath>& path) {
  return path ? "no error" : path.error().text();
}
Point3 endOf(const Result<ToolPath>& path) {
  EXPECT_TRUE(path) << refusalOf(path);
  return path ? path->motion.segments.back().end.translation : Point3::Zero();
}
double durationOf(const Result<ToolPath>& path) {
  EXPECT_TRUE(path) << refusalOf(path);
  return path ? path->motion.timeEnd() - path->motion.timeBegin() : -1;
}
/// Of the way that the tip goes.
double lengthOf(const Result<ToolPath>& path) {
  EXPECT_TRUE(path) << refusalOf(path);
  if (!path) return -1;
  double length = 0;
  for (const auto& segment : path->motion.segments) {
    length += (segment.end.translation - segment.start.translation).norm();
  }
  return length;
}

TEST(Gcode, StraightMovesTakeTheirLengthByTheFeed) {
  const auto path =
      gcode("%\nO1 (part)\nN10 g21 g90 g17\nG0 X0Y0Z5\nG1 Z0 F300 ; down\nx 1 0\nM30\n%");
  ASSERT_TRUE(path) << refusalOf(path);
  EXPECT_EQ(endOf(path), Point3(10, 0, 0));
  EXPECT_NEAR(durationOf(path), 1 + 2, 1e-12);
  EXPECT_EQ(path->moves, 3U);
  EXPECT_TRUE(path->rapids.empty());
  EXPECT_EQ(path->motion.lengthUnit, "mm");
  EXPECT_EQ(path->motion.timeUnit, "s");
}

TEST(Gcode, ThePathStartsWhereAllAxesAreKnown) {
  const auto path = gcode("G0 Z5\nG0 X1 Y2\nG0 X4 Y6\n", {.rapidFeed = 600});
  ASSERT_TRUE(path) << refusalOf(path);
  EXPECT_EQ(path->motion.segments.size(), 1U);
  EXPECT_EQ(path->motion.segments[0].start.translation, Point3(1, 2, 5));
  EXPECT_NEAR(durationOf(path), 0.5, 1e-12);
  ASSERT_EQ(path->rapids.size(), 1U);
  EXPECT_NEAR(path->rapids[0].end, 0.5, 1e-12);
}

TEST(Gcode, InchesAndRelativePositions) {
  EXPECT_NEAR(
      (endOf(gcode("G20 G0 X1 Y0 Z0\nG91 G1 X1 Y2 F10\nG21 Z-3")) - Point3(50.8, 50.8, -3)).norm(),
      0, 1e-12);
  EXPECT_NEAR(durationOf(gcode("G20 G0 X0 Y0 Z0\nG1 X10 F10")), 60, 1e-9);
}

TEST(Gcode, ArcsByCentreAndByRadiusAreTheSame) {
  // A quarter, three quarters, both ways round, in each plane: the way is r times the angle.
  const ToolPathOptions fine{.tolerance = 1e-6};
  const std::string start = "G0 X10 Y0 Z0 F600\n";
  const double quarter = 5 * std::numbers::pi;
  EXPECT_NEAR(lengthOf(gcode(start + "G3 X0 Y10 I-10 J0", fine)), quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode(start + "G3 X0 Y10 R10", fine)), quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode(start + "G2 X0 Y10 I-10", fine)), 3 * quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode(start + "G2 X0 Y10 R-10", fine)), 3 * quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode(start + "G2 I-10", fine)), 4 * quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode(start + "G90.1 G3 X0 Y10 I0 J0", fine)), quarter, 1e-5);
  // From z to x is the positive way round in G18, so this is three quarters.
  EXPECT_NEAR(lengthOf(gcode(start + "G18 G3 X0 Z10 I-10 K0", fine)), 3 * quarter, 1e-5);
  EXPECT_NEAR(lengthOf(gcode("G0 X0 Y10 Z0 F600\nG19 G3 Y0 Z10 J-10 K0", fine)), quarter, 1e-5);
  EXPECT_NEAR(durationOf(gcode(start + "G3 X0 Y10 I-10", fine)), quarter / 10, 1e-9);
}

TEST(Gcode, AHelixRisesEvenly) {
  const auto path = gcode("G0 X10 Y0 Z0\nG3 X10 Y0 Z4 I-10 F600", {.tolerance = 1e-6});
  ASSERT_TRUE(path) << refusalOf(path);
  const auto half = path->motion.at(path->motion.timeEnd() / 2).translation;
  EXPECT_NEAR((half - Point3(-10, 0, 2)).norm(), 0, 2e-6);
  EXPECT_EQ(endOf(path), Point3(10, 0, 4));
}

TEST(Gcode, ChordsStayWithinTheTolerance) {
  for (const double tolerance : {1.0, 0.1, 1e-3}) {
    const auto path = gcode("G0 X7 Y0 Z0\nG2 I-7 F100", {.tolerance = tolerance});
    ASSERT_TRUE(path) << refusalOf(path);
    for (const auto& segment : path->motion.segments) {
      const Point3 middle = 0.5 * (segment.start.translation + segment.end.translation);
      EXPECT_LE(7 - middle.norm(), tolerance * (1 + 1e-9));
      EXPECT_NEAR(segment.end.translation.norm(), 7, 1e-12);
    }
  }
}

TEST(Gcode, ChordsOfAnArcThatGrowsFollowItsLargerRadius) {
  // A quarter that begins at a radius of 10 and ends at 10.009, or the other way round.
  for (const auto& [radius, end] : {std::pair{10.0, 10.009}, {10.009, 10.0}}) {
    for (double tolerance = 1e-4; tolerance < 1e-3; tolerance *= 1.01) {
      const auto path = gcode(fmt::format("G0 X{0} Y0 Z0 F600\nG3 X0 Y{1} I-{0} J0", radius, end),
                              {.tolerance = tolerance});
      ASSERT_TRUE(path) << refusalOf(path);
      const double chords =
          std::ceil(std::numbers::pi / 4 / std::acos(1 - tolerance / 10.009) - 1e-9);
      ASSERT_EQ(path->motion.segments.size(), static_cast<std::size_t>(chords)) << tolerance;
    }
  }
}

TEST(Gcode, RadiiOfAnArcMayDifferByRoundingOfSmallAndOfLargeOnes) {
  const auto isRead = [](double radius, double end) {
    return refusalOf(gcode(fmt::format("G0 X{0} Y0 Z0 F600\nG3 X0 Y{1} I-{0} J0", radius, end)))
               .find("from its centre") == std::string::npos;
  };
  EXPECT_TRUE(isRead(1, 1.009));
  EXPECT_FALSE(isRead(1, 1.011));
  EXPECT_TRUE(isRead(100, 100.09));
  EXPECT_FALSE(isRead(100, 99.89));
}

TEST(Gcode, WhatIsNotUnderstoodIsRefusedByNameAndLine) {
  const std::string start = "G0 X0 Y0 Z0\nF100\n";
  EXPECT_EQ(refusalOf(gcode(start + "G41 D1")),
            "a.nc:3: G41 is not supported: it is cutter compensation; have the path of the tool's "
            "centre written");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 A30")),
            "a.nc:3: A30 is not supported: it is a rotary axis; for five axes give cutter "
            "locations (GOTO/x,y,z,i,j,k)");
  EXPECT_EQ(refusalOf(gcode(start + "G81 X1 Z-2 R1")),
            "a.nc:3: G81 is not supported: it is a canned cycle; have its moves written");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X#5")),
            "a.nc:3: # is not supported: it is a variable or an expression; have plain numbers "
            "written");
  EXPECT_EQ(refusalOf(gcode(start + "M77")),
            "a.nc:3: M77 is not supported: it is not among the words that are known");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 (TOOL (6 MM) O.K)")),
            "a.nc:3: a closing bracket has no opening one: comments cannot be nested");
  EXPECT_EQ(refusalOf(gcode(start + "G1 Xa")), "a.nc:3: X is followed by 'A', expected a number");
  EXPECT_EQ(refusalOf(gcode(start + "G0 G1 X1")),
            "a.nc:3: G1: another word in the line says the same or the opposite");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG1 X1")),
            "a.nc:2: a cutting move has no feed; give F before");
  EXPECT_EQ(refusalOf(gcode("G1 X0 F10")),
            "a.nc:1: a cutting move comes before X, Y and Z have been given; begin with G0 and "
            "all three");
  EXPECT_EQ(refusalOf(gcode(start + "G2 X5")),
            "a.nc:3: an arc has neither centre (I, J, K) nor radius (R)");
  EXPECT_EQ(refusalOf(gcode(start + "G2 X5 I1")),
            "a.nc:3: the arc begins 1 mm from its centre and ends 4 mm from it");
  EXPECT_EQ(refusalOf(gcode(start + "G4 P1 I3")),
            "a.nc:3: G4 (a dwell) stands with coordinates or with R");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 P2")), "a.nc:3: P2 stands without G2, G3, G4 or G64");
  EXPECT_EQ(refusalOf(gcode(start + "G4 P0.5\nG64 P0.01\nG2 X2 I1 P1\nG1 X5")), "no error");
  EXPECT_EQ(refusalOf(gcode(start + "(no end")), "a.nc:3: a comment has no closing bracket");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\n")),
            "a.nc: nothing moves: there are no two different positions of the tool");
  EXPECT_EQ(refusalOf(gcode(start + "T1 M6\nG1 X1\nT2 M6")),
            "a.nc:5: a second tool is mounted (T2), but one tool mills at a time; divide the "
            "program, and mill the parts one after another");
  EXPECT_EQ(refusalOf(gcode(start + "G55\nG1 X1")),
            "a.nc:3: G55 is not supported: it is a second origin, after G54; have plain "
            "coordinates written");
  EXPECT_EQ(refusalOf(gcode(start + "G54 G55")),
            "a.nc:3: G55: another word in the line says the same or the opposite");
}

TEST(Gcode, DwellsAndLinesThatMayBeLeftOutAreNoted) {
  const auto noticesOf = [](const std::string& text) {
    const auto path = gcode("G0 X0 Y0 Z0\nF100\nG1 X1\n" + text);
    EXPECT_TRUE(path) << refusalOf(path);
    return path ? path->notices : std::vector<std::string>{};
  };
  using Notices = std::vector<std::string>;
  EXPECT_EQ(noticesOf(""), Notices{});
  EXPECT_EQ(noticesOf("G4 P1\n"), Notices{"a.nc: 1 dwell takes no time here (G4)"});
  EXPECT_EQ(noticesOf("G4 P1\nG4 P2\n"), Notices{"a.nc: 2 dwells take no time here (G4)"});
  EXPECT_EQ(noticesOf("/G1 X2\n"), Notices{"a.nc: 1 line with / (block delete) is carried out"});
  EXPECT_EQ(noticesOf("/G1 X2\n/X3\n"),
            Notices{"a.nc: 2 lines with / (block delete) are carried out"});
}

TEST(Gcode, OneOriginMayBeChosen) {
  // G54 in the last line chooses an origin for no move.
  const auto path = gcode("G55\nG0 X0 Y0 Z0\nG55 G1 X1 F100\n/G1 X2\nG54\n");
  ASSERT_TRUE(path) << path.error().text();
  EXPECT_EQ(path->moves, 3U);
  ASSERT_EQ(path->notices.size(), 1U);
  EXPECT_EQ(path->notices[0], "a.nc: 1 line with / (block delete) is carried out");
}

TEST(CutterLocations, TheTipGoesStraightWhileTheToolTurns) {
  const auto path = locations(
      "PARTNO/A\nUNITS/MM\nFEDRAT/600,MMPM\n$$ begin\nGOTO/0,0,0,0,0,1\n"
      "GOTO/10,0,0, $\n  1,0,1\n");
  ASSERT_TRUE(path) << refusalOf(path);
  ASSERT_EQ(path->motion.segments.size(), 1U);
  EXPECT_NEAR(durationOf(path), 1, 1e-12);
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const model::Pose pose = path->motion.at(t);
    EXPECT_NEAR((pose(Point3::Zero()) - Point3(10 * t, 0, 0)).norm(), 0, 1e-12);
    const double angle = t * std::numbers::pi / 4;
    EXPECT_NEAR(
        (pose.rotation * Point3::UnitZ() - Point3(std::sin(angle), 0, std::cos(angle))).norm(), 0,
        1e-12);
  }
}

TEST(CutterLocations, RapidIsForOneMove) {
  const auto path =
      locations("FEDRAT/60\nFROM/0,0,0\nRAPID\nGOTO/0,0,10\nGOTO/0,0,0\nFINI\nnothing of this");
  ASSERT_TRUE(path) << refusalOf(path);
  EXPECT_EQ(path->rapids.size(), 1U);
  EXPECT_NEAR(durationOf(path), 0.06 + 10, 1e-12);
}

TEST(CutterLocations, WhatIsNotUnderstoodIsRefusedByNameAndLine) {
  EXPECT_EQ(refusalOf(locations("FEDRAT/60\nCYCLE/DRILL,5")),
            "a.cl:2: 'CYCLE' is not supported; known are GOTO, FROM, FEDRAT, RAPID, UNITS, and "
            "statements that move nothing");
  EXPECT_EQ(refusalOf(locations("GOTO/1,2")),
            "a.cl:1: GOTO has 2 numbers; expected x,y,z or x,y,z,i,j,k");
  EXPECT_EQ(refusalOf(locations("GOTO/1,2,x")), "a.cl:1: found 'X', expected a number");
  EXPECT_EQ(refusalOf(locations("GOTO/0,0,0,0,0,0")),
            "a.cl:1: the axis of the tool has the length zero");
  EXPECT_EQ(refusalOf(locations("GOTO/0,0,0\nGOTO/1,0,0")),
            "a.cl:2: a move has no feed; give FEDRAT before");
  EXPECT_EQ(refusalOf(locations("FEDRAT/1\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,-1")),
            "a.cl:3: the tool turns by half a turn in one move, which could be any way round; "
            "give an axis between");
}

/// Digits of a text decide which way such a turn goes.
TEST(CutterLocations, ATurnThatRoundingMakesAHalfTurnIsRefused) {
  for (const char* axis : {"0.00001,0,-1", "0,-0.001,-1", "-0.002,0.002,-1"}) {
    EXPECT_EQ(refusalOf(locations(std::string("FEDRAT/1\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,") + axis)),
              "a.cl:3: the tool turns by half a turn in one move, which could be any way round; "
              "give an axis between")
        << axis;
  }
  EXPECT_TRUE(locations("FEDRAT/1\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0.004,0,-1"));
}

}  // namespace
}  // namespace t4d::formats
