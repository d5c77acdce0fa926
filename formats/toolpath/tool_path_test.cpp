#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "formats/toolpath/cutter_location_reader.h"
#include "formats/toolpath/gcode_reader.h"
#include "formats/toolpath/tool_table.h"

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
  EXPECT_TRUE(isRead(1, 1.028));
  EXPECT_FALSE(isRead(1, 1.029));
  EXPECT_TRUE(isRead(100, 100.09));
  EXPECT_FALSE(isRead(100, 99.89));
  // As LinuxCNC's own tests have it: good/good-arc.small.metric, bad/bad-arc.big.metric.
  EXPECT_TRUE(isRead(24.986, 25.014));
  EXPECT_FALSE(isRead(3001.43, 2998.57));
}

TEST(Gcode, RadiiInInchesMayDifferByTheRoundingOfTheirDigits) {
  const auto isRead = [](double radius, double end) {
    return refusalOf(gcode(fmt::format("G20 G0 X{0} Y0 Z0 F60\nG3 X0 Y{1} I-{0} J0", radius, end)))
               .find("from its centre") == std::string::npos;
  };
  EXPECT_TRUE(isRead(1, 1.0028));
  EXPECT_FALSE(isRead(1, 1.0029));
}

TEST(Gcode, WhatIsNotUnderstoodIsRefusedByNameAndLine) {
  const std::string start = "G0 X0 Y0 Z0\nF100\n";
  EXPECT_EQ(refusalOf(gcode(start + "G41 D1")),
            "a.nc:3: G41 D1: there is no tool 1, whose diameter D names");
  EXPECT_EQ(refusalOf(gcode(start + "G12.1")),
            "a.nc:3: G12.1 is not supported: it is polar interpolation, after which X and C are "
            "not what they were; have the moves of X and Y written");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 A30")),
            "a.nc:3: A30 is not supported: it is a rotary axis; say how the machine turns, or give "
            "cutter locations (GOTO/x,y,z,i,j,k)");
  EXPECT_EQ(refusalOf(gcode(start + "G87 X1 Z-2 R1")),
            "a.nc:3: G87 is not supported: it is a boring cycle that needs an operator; have its "
            "moves written");
  EXPECT_EQ(refusalOf(gcode(start + "M77")),
            "a.nc:3: M77 is not supported: it is not among the words that are known; take it out "
            "if it moves nothing");
  EXPECT_EQ(refusalOf(gcode(start + "IF [1 GT 0] GOTO 7")), "a.nc:3: GOTO 7: no line has N7");
  EXPECT_EQ(refusalOf(gcode(start + "X1 GOTO 7")),
            "a.nc:3: GOTO stands in a line behind other words");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 (TOOL (6 MM) O.K)")),
            "a.nc:3: a closing bracket has no opening one: comments cannot be nested");
  EXPECT_EQ(refusalOf(gcode(start + "G1 Xb")), "a.nc:3: X is followed by 'B', expected a number");
  EXPECT_EQ(refusalOf(gcode(start + "G0 G1 X1")),
            "a.nc:3: G1: another word in the line says the same or the opposite");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG1 X1")),
            "a.nc:2: a cutting move has no feed; give F before, or --feed");
  EXPECT_EQ(refusalOf(gcode(start + "G2 X5")),
            "a.nc:3: an arc has neither centre (I, J, K) nor radius (R)");
  EXPECT_EQ(refusalOf(gcode(start + "G2 X5 I1")),
            "a.nc:3: the arc begins 1 mm from its centre and ends 4 mm from it");
  EXPECT_EQ(refusalOf(gcode(start + "G4 Y3")),
            "a.nc:3: G4 (a dwell) stands with coordinates or R, and without P, its seconds");
  EXPECT_EQ(refusalOf(gcode(start + "G1 X1 P2")),
            "a.nc:3: P2 stands without G2, G3, G4, G10, G64, M98 or a canned cycle");
  EXPECT_EQ(refusalOf(gcode(start + "G4 P0.5\nG64 P0.01\nG2 X2 I1 P1\nG1 X5")), "no error");
  EXPECT_EQ(refusalOf(gcode(start + "(no end")), "a.nc:3: a comment has no closing bracket");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\n")),
            "a.nc: nothing moves: there are no two different positions of the tool");
  EXPECT_EQ(refusalOf(gcode(start + "T1 M6\nG1 X1\nT2 M6")),
            "a.nc:5: a second tool is mounted (T2), and one is given for all");
  EXPECT_EQ(refusalOf(gcode(start + "G55\nG1 X1")),
            "a.nc:4: G55 is a second origin, after G54; say where it is in the frame of the stock");
  EXPECT_EQ(refusalOf(gcode(start + "G54 G55")),
            "a.nc:3: G55: another word in the line says the same or the opposite");
}

TEST(Gcode, BeforeThePlaceIsSaidTheToolIsAtItsStart) {
  ToolPathOptions options;
  options.start = Point3(1, 2, 3);
  // It is told, so moves from there cut.
  const auto told = gcode("G1 X5 F240\nY4", options);
  ASSERT_TRUE(told) << refusalOf(told);
  EXPECT_EQ(told->motion.segments[0].start.translation, Point3(1, 2, 3));
  EXPECT_EQ(endOf(told), Point3(5, 4, 3));
  EXPECT_TRUE(told->rapids.empty());
  EXPECT_TRUE(told->notices.empty());
  // It is guessed, so the way from there is no cut, and the moves after it are.
  options.start.reset();
  options.assumedStart = Point3(0, 0, 10);
  const auto guessed = gcode("G1 X4 Y3 Z10 F60\nZ9", options);
  ASSERT_TRUE(guessed) << refusalOf(guessed);
  ASSERT_EQ(guessed->rapids.size(), 1U);
  EXPECT_NEAR(guessed->rapids[0].end, 60 * 5.0 / 10'000, 1e-12);
  EXPECT_NEAR(durationOf(guessed), guessed->rapids[0].end + 1, 1e-12);
  EXPECT_EQ(guessed->notices,
            (std::vector<std::string>{
                "a.nc:1: X, Y, Z have not been given before: the tool begins at (0, 0, 10) mm, the "
                "middle of the stock's top; --start X,Y,Z says where",
                "a.nc:1: the way there from where the tool begins is drawn as a rapid move"}));
  // An axis that is never named stays there, and what others cut is cut.
  const auto never = gcode("G0 X-5 Z12\nG1 Z8 F600\nX5", options);
  ASSERT_TRUE(never) << refusalOf(never);
  EXPECT_EQ(endOf(never), Point3(5, 0, 8));
  EXPECT_TRUE(never->rapids.empty());
  // A rapid move names an axis as well.
  const auto named = gcode("G1 X0 Y0 F60\nG0 Z15\nG1 Z14", options);
  ASSERT_TRUE(named) << refusalOf(named);
  EXPECT_NEAR(durationOf(named), named->rapids[0].end + 1, 1e-12);
  // Where the zero of the machine is known, it begins there.
  options.offsets = {{530, Point3(0, 0, 50)}};
  EXPECT_EQ(gcode("G1 X1 Y1 Z1 F60", options)->motion.segments[0].start.translation,
            Point3(0, 0, 50));
  // Coordinates before any G word are rapid moves, and moves that are relative need no place.
  EXPECT_EQ(gcode("X1 Y2 Z3\nX4")->rapids.size(), 1U);
  EXPECT_EQ(endOf(gcode("G91 G1 X1 F60\nY2")), Point3(1, 2, 0));
}

TEST(Gcode, AFeedIsGivenWhereAProgramHasNone) {
  ToolPathOptions options;
  options.defaultFeed = 120;
  EXPECT_NEAR(durationOf(gcode("G0 X0 Y0 Z0\nG1 X4\nF60 X5", options)), 2 + 1, 1e-12);
}

TEST(Gcode, AFeedBesideUnitsCountsBeforeThem) {
  const auto path = gcode("G21 G0 X0 Y0 Z0\nG20 G1 X1 F25.4");
  ASSERT_TRUE(path) << refusalOf(path);
  EXPECT_NEAR(durationOf(path), 60, 1e-9);
  EXPECT_EQ(path->notices[0],
            "a.nc:2: F25.4 stands in the line of G20 and counts before it, as in LinuxCNC: 25.4 "
            "mm/min; on other controls it is 645.16 mm/min");
}

TEST(Gcode, WhatTurnsScalesAndMirrorsAProgramDoesIt) {
  const std::string start = "G0 X0 Y0 Z0\n";
  const auto endsAt = [&](const std::string& text, const Point3& end) {
    EXPECT_NEAR((endOf(gcode(start + text)) - end).norm(), 0, 1e-12) << text;
  };
  endsAt("G68 X1 Y0 R90\nX3 Y1", {0, 2, 0});
  endsAt("G68 X1 Y0 R90\nX3\nG69\nX4", {4, 2, 0});
  endsAt("G68 X0 Y0 R90\nX1\nG91 X1", {0, 2, 0});
  endsAt("G18 G68 X0 Z0 R90\nX1", {0, 0, -1});
  endsAt("G51 X1 Y1 Z0 P2.0\nX3 Y4 Z5", {5, 7, 10});
  endsAt("G51 X0 Y0 Z0 P2000\nX3 Y4 Z5", {6, 8, 10});
  endsAt("G51 X0 Y0 Z0 I2.0 J3.0\nX1 Y1\nG50\nZ2", {2, 3, 2});
  endsAt("G51.1 X2\nX5 Y1", {-1, 1, 0});
  endsAt("G51.1 X0 Y0\nX5 Y1\nG50.1 X0\nX5", {5, -1, 0});
  endsAt("G16\nX2 Y90", {0, 2, 0});
  endsAt("G16\nX2 Y90\nG15\nX1", {1, 2, 0});
  endsAt("@2 ^90\n^180", {-2, 0, 0});
  endsAt("G10 L2 P1 R90\nX3 Y1", {-1, 3, 0});
  // A mirrored arc turns the other way, and scaled ones are longer, by the same feed.
  const double quarter = std::numbers::pi / 2 * 10;
  const std::string arc = "X10\nG3 X0 Y10 I-10 F600";
  EXPECT_NEAR(lengthOf(gcode(start + "G51.1 X0\n" + arc, {.tolerance = 1e-6})), 10 + quarter, 1e-4);
  const auto scaled = gcode(start + "G51 X0 Y0 Z0 P2.\n" + arc, {.tolerance = 1e-6});
  EXPECT_NEAR(lengthOf(scaled), 2 * (10 + quarter), 1e-4);
  EXPECT_NEAR(durationOf(scaled), 60 * 20.0 / 10'000 + 2 * quarter / 10, 1e-9);
  EXPECT_NE(refusalOf(gcode(start + "G51 X0 Y0 Z0 I2. J3.\n" + arc)).find("scales the axes"),
            std::string::npos);
  EXPECT_NE(refusalOf(gcode(start + "G51 X2 Y2 Z1\nX1")).find("--dialect mach3"),
            std::string::npos);
  ToolPathOptions mach3;
  mach3.dialect = GcodeDialect::Mach3;
  EXPECT_EQ(endOf(gcode(start + "G51 X2 Y2 Z1\nX1 Y1 Z1", mach3)), Point3(2, 2, 1));
}

TEST(Gcode, SplinesGoWhereTheirPointsSay) {
  const ToolPathOptions fine{.tolerance = 1e-6};
  const std::string start = "G0 X0 Y0 Z0 F60\n";
  // A parabola y = x (1 - x) / 2 from 0 to 1, as a quadratic and as a cubic.
  const double length = std::sqrt(5.0) / 4 + std::asinh(0.5);
  const auto quadratic = gcode(start + "G5.1 X1 Y0 I.5 J.25", fine);
  EXPECT_NEAR(lengthOf(quadratic), length, 1e-5);
  const auto cubic = gcode(start + "G5 X1 Y0 I[1/3] J[1/6] P[-1/3] Q[1/6]", fine);
  EXPECT_NEAR(lengthOf(quadratic), lengthOf(cubic), 1e-5);
  EXPECT_NEAR(durationOf(quadratic), lengthOf(quadratic), 1e-9);
  // With this weight, three points are a quarter of a circle.
  const auto nurbs = gcode("G0 X1 Y0 Z0 F60\nG5.2 X1 Y1 P[SQRT[2]/2] L3\nX0 Y1 P1\nG5.3\n", fine);
  EXPECT_NEAR(lengthOf(nurbs), std::numbers::pi / 2, 1e-5);
  for (const auto& segment : nurbs->motion.segments) {
    EXPECT_NEAR(segment.end.translation.norm(), 1, 1e-12);
  }
  EXPECT_NE(refusalOf(gcode(start + "G5.2 X1 Y1 L3\nX2")).find("G5.2 is not ended"),
            std::string::npos);
  // A thread of pitch 2 at 60 turns a minute, and back.
  EXPECT_NEAR(durationOf(gcode(start + "S60\nG33.1 Z-10 K2", fine)), 10, 1e-12);
}

TEST(Gcode, TheCutterStaysBesideThePath) {
  ToolPathOptions options{.tolerance = 1e-6};
  options.diameters = {{0, 2}};
  const std::string start = "G0 X-10 Y0 Z0 F60\n";
  // Along a line, a square corner inside and one outside of it.
  EXPECT_NEAR((endOf(gcode(start + "G41 G1 X0\nX10\nY10\nG40", options)) - Point3(9, 10, 0)).norm(),
              0, 1e-12);
  EXPECT_NEAR(lengthOf(gcode(start + "G41 G1 X0\nX10\nY10", options)),
              std::hypot(10.0, 1.0) + 9 + 9, 1e-9);
  EXPECT_NEAR(lengthOf(gcode(start + "G42 G1 X0\nX10\nY10", options)),
              std::hypot(10.0, 1.0) + 10 + std::numbers::pi / 2 + 10, 1e-4);
  // D gives the diameter, a negative one the other side.
  EXPECT_NEAR(
      (endOf(gcode(start + "G42.1 D-4 G1 X0\nX10\nG40", options)) - Point3(10, 2, 0)).norm(), 0,
      1e-12);
  EXPECT_NE(refusalOf(gcode(start + "G41 G1 X0\nX3\nX2 Y.1\nX1", options)).find("too narrow"),
            std::string::npos);
  EXPECT_NE(refusalOf(gcode(start + "G41 G1 X-9.5\nX3", options)).find("not longer than"),
            std::string::npos);
  // Nothing else comes between two moves of which the first one waits for the second.
  options.offsets = {{530, Point3::Zero()}};
  for (const char* word : {"T2 M6", "G18", "G28 Z0", "G53 G0 Z9"}) {
    EXPECT_NE(refusalOf(gcode(start + "G41 G1 X0\n" + word, options)).find("give G40 before"),
              std::string::npos)
        << word;
    EXPECT_NE(refusalOf(gcode(start + "G1 X0,R1\n" + word, options)).find("has no straight move"),
              std::string::npos)
        << word;
  }
}

TEST(Gcode, CornersAreRoundedAndCutOff) {
  const std::string start = "G0 X0 Y0 Z0 F60\nG1 X10";
  EXPECT_NEAR(lengthOf(gcode(start + ",R2\nY10", {.tolerance = 1e-6})), 16 + std::numbers::pi,
              1e-4);
  EXPECT_NEAR(lengthOf(gcode(start + ",C2\nY10")), 16 + std::sqrt(8.0), 1e-9);
  EXPECT_NEAR(lengthOf(gcode(start + ",R2\nY10,R2\nX0", {.tolerance = 1e-6})),
              8 + 6 + 8 + 2 * std::numbers::pi, 1e-4);
  EXPECT_NE(refusalOf(gcode(start + ",R20\nY10")).find("takes 20 mm of its moves"),
            std::string::npos);
  EXPECT_NE(refusalOf(gcode(start + ",R2\nG2 X12 I1")).find(",R in line 2 has no straight move"),
            std::string::npos);
  EXPECT_NE(refusalOf(gcode(start + ",R2")).find("has no straight move after it"),
            std::string::npos);
}

TEST(Gcode, MacrosOfFanucsControlsAreCarriedOut) {
  const std::string start = "G0 X0 Y0 Z0 F60\n";
  EXPECT_EQ(endOf(gcode(start + "#1=0\nWHILE [#1 LT 3] DO 1\n#1=#1+1\nG1 X#1\nEND 1")),
            Point3(3, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "#1=0\nN10 #1=#1+1\nG1 X#1\nIF [#1 LT 4] GOTO 10")),
            Point3(4, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "GOTO 20\nG1 X9\nN20 G1 Y1")), Point3(0, 1, 0));
  EXPECT_EQ(endOf(gcode(start + "IF [1 EQ 1] THEN #2=5\nG1 X#2")), Point3(5, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "G65 P100 A2 B3 X7\nM30\nO100\nG1 X#1 Y#2 Z#24\nM99")),
            Point3(2, 3, 7));
  EXPECT_EQ(endOf(gcode(start + "M98 P30100\nM30\nO0100\nG91 G1 X2\nM99")), Point3(6, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "M97 P7\nM30\nN7 G1 X3\nM99")), Point3(3, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "o[1+1] call\nM2\n" + "o2 sub\nG1 X8\no2 endsub")),
            Point3(8, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "G1 X[EXISTS[#1]]\n#1=5\nX[1+EXISTS[#1]]")), Point3(2, 0, 0));
  EXPECT_EQ(endOf(gcode(start + "M70 G91 M73\nM72 G1 X3\nX4")), Point3(4, 0, 0));
  const auto endless = gcode(start + "G1 X1\nM99");
  ASSERT_TRUE(endless) << refusalOf(endless);
  EXPECT_EQ(endless->notices[0], "a.nc: M99 repeats the program for ever; it is carried out once");
}

TEST(Gcode, DialectsDifferInNumbersWithoutAPointAndInCycles) {
  ToolPathOptions fanuc;
  fanuc.dialect = GcodeDialect::Fanuc;
  EXPECT_EQ(endOf(gcode("G0 X0 Y0 Z0\nX5000 Y2.5", fanuc)), Point3(5, 2.5, 0));
  EXPECT_EQ(endOf(gcode("G20 G0 X0 Y0 Z0\nX10000", fanuc)), Point3(25.4, 0, 0));
  EXPECT_EQ(endOf(gcode("G0 X0 Y0 Z0\nX5000")), Point3(5000, 0, 0));
  // It looks like one of Fanuc's.
  const auto guessed = gcode("%\nO1234\nG0 X0 Y0 Z0\nX5000\nM30\n%");
  EXPECT_EQ(endOf(guessed), Point3(5, 0, 0));
  EXPECT_EQ(guessed->notices.size(), 1U);
  EXPECT_EQ(endOf(gcode("%\nO1234\nG0 X0 Y0 Z0\nX5000 Y1.5\nM30\n%")), Point3(5000, 1.5, 0));
  // So it does in cycles that say nothing of their retraction, with a note.
  const std::string hole = "G0 X0 Y0 Z9\nG81 X1 Z-3 R1 F60\n";
  const auto cycle = gcode("%\nO1234\n" + hole + "M30\n%");
  EXPECT_EQ(endOf(cycle), Point3(1, 0, 9));
  ASSERT_EQ(cycle->notices.size(), 1U);
  EXPECT_NE(cycle->notices[0].find("cycles begin with G98"), std::string::npos);
  EXPECT_TRUE(gcode("%\nO1234\nG98\n" + hole + "M30\n%")->notices.empty());
  EXPECT_EQ(endOf(gcode(hole)), Point3(1, 0, 1));
  ToolPathOptions siemens;
  siemens.dialect = GcodeDialect::Siemens;
  EXPECT_EQ(endOf(gcode("G70 G0 X0 Y0 Z0\nX1", siemens)), Point3(25.4, 0, 0));
  EXPECT_NEAR(lengthOf(gcode("G0 X0 Y0 Z0 F60\nG2 X2 Y0 CR=1", {.tolerance = 1e-7})),
              std::numbers::pi, 1e-5);
  EXPECT_NE(refusalOf(gcode("G71 X1")).find("--dialect siemens"), std::string::npos);
}

TEST(Gcode, WordsThatEndWhatNeverBeganDoNothing) {
  for (const char* word : {"G15", "G50", "G50.1", "G69", "M107", "G13.1", "G40.1", "G67", "G64",
                           "G8 P1", "G5.1 Q1", "G187 P2 E.01", "M66 P1 L0", "G9", "G113"}) {
    EXPECT_EQ(refusalOf(gcode(std::string("G0 X0 Y0 Z0\n") + word + "\nX1")), "no error") << word;
  }
}

TEST(Gcode, ErrorsSayByTheirRemedyWhatMayHelp) {
  const std::string start = "G0 X0 Y0 Z0\nF100\n";
  const auto remedyOf = [&](const std::string& text, const ToolPathOptions& options = {}) {
    const auto path = gcode(start + text, options);
    EXPECT_FALSE(path) << text;
    return path ? Remedy::None : path.error().remedy;
  };
  EXPECT_EQ(remedyOf("G1 X1 A30"), Remedy::RotaryAxis);
  EXPECT_EQ(remedyOf("T1 M6\nG1 X1\nT2 M6"), Remedy::EachTool);
  EXPECT_EQ(remedyOf("T7 M6", {.tools = std::vector{1}}), Remedy::EachTool);
  EXPECT_EQ(remedyOf("G1 X1", {.tools = std::vector{1}}), Remedy::AnyTool);
  EXPECT_EQ(remedyOf("G55\nG1 X1"), Remedy::Origin);
  EXPECT_EQ(remedyOf("#5221=3"), Remedy::Origin);
  EXPECT_EQ(remedyOf("G43.1 Z5"), Remedy::ToolTable);
  EXPECT_EQ(remedyOf("G10 L1 P1 Z5"), Remedy::ToolTable);
  EXPECT_EQ(remedyOf("G10 L2 P1 X0"), Remedy::MachineZero);
  EXPECT_EQ(remedyOf("G53 G1 X1"), Remedy::MachineZero);
  EXPECT_EQ(remedyOf("G28 Z5\nG0 X9\nG1 X8"), Remedy::MachineZero);
}

TEST(Gcode, DwellsAndLinesThatMayBeLeftOutAreNoted) {
  const auto noticesOf = [](const std::string& text) {
    const auto path = gcode("G0 X0 Y0 Z0\nF100\nG1 X1\n" + text);
    EXPECT_TRUE(path) << refusalOf(path);
    return path ? path->notices : std::vector<std::string>{};
  };
  using Notices = std::vector<std::string>;
  EXPECT_EQ(noticesOf(""), Notices{});
  EXPECT_EQ(noticesOf("G4 P1\n"), Notices{"a.nc: 1 dwell takes no time here"});
  EXPECT_EQ(noticesOf("G4 P1 G0 X1\n"), Notices{"a.nc: 1 dwell takes no time here"});
  EXPECT_EQ(noticesOf("G4 P1\nG4 P2\n"), Notices{"a.nc: 2 dwells take no time here"});
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

/// Where the tool goes, a point a move.
std::vector<Point3> placesOf(const Result<ToolPath>& path) {
  EXPECT_TRUE(path) << refusalOf(path);
  std::vector<Point3> places;
  if (!path) return places;
  for (const auto& segment : path->motion.segments) places.push_back(segment.end.translation);
  return places;
}
/// Heights of the moves after a rapid one to (0, 0, 5).
std::vector<double> heightsOf(const std::string& text) {
  std::vector<double> heights;
  for (const Point3& place : placesOf(gcode("G0 X0 Y0 Z5 F60\n" + text))) {
    heights.push_back(std::round(place.z() * 1e6) / 1e6);
  }
  return heights;
}

TEST(Gcode, CannedCyclesGoAsLinuxCncDoes) {
  using Heights = std::vector<double>;
  EXPECT_EQ(heightsOf("G98 G81 X1 Z-3 R1"), (Heights{5, 1, -3, 5}));
  EXPECT_EQ(heightsOf("G99 G81 X1 Z-3 R1\nX2\nG80\nG0 X3"), (Heights{5, 1, -3, 1, 1, -3, 1, 1}));
  EXPECT_EQ(heightsOf("G98 G83 X1 Z-3 R1 Q1.5"),
            (Heights{5, 1, -0.5, 1, -0.246, -2, 1, -1.746, -3, 5}));
  EXPECT_EQ(heightsOf("G98 G73 X1 Z-3 R1 Q1.5"), (Heights{5, 1, -0.5, -0.246, -2, -1.746, -3, 5}));
  EXPECT_EQ(heightsOf("G98 G91 G81 X1 Z-3 R-1 L2"), (Heights{5, 4, 1, 5, 5, 4, 1, 5}));
  // G98 goes back to where the series began, also after G99.
  EXPECT_EQ(heightsOf("G99 G81 X1 Z-3 R1\nG98 X2"), (Heights{5, 1, -3, 1, 5, 1, -3, 5}));
  // As LinuxCNC begins.
  EXPECT_EQ(heightsOf("G81 X1 Z-3 R1"), (Heights{5, 1, -3, 1}));
  // Below R it rises first.
  EXPECT_EQ(heightsOf("G0 Z0\nG81 X1 Z-3 R1"), (Heights{0, 1, 1, -3, 1}));
  // The boring cycles come back by feed.
  const auto rapidsOf = [](const std::string& cycle) {
    const auto path = gcode("G0 X0 Y0 Z5 F60\n" + cycle + " X0 Z-3 R5\nG1 X9\n");
    EXPECT_TRUE(path) << refusalOf(path);
    return path ? path->rapids.size() : 99;
  };
  EXPECT_EQ(rapidsOf("G82 P1"), 1U);
  EXPECT_EQ(rapidsOf("G86 P1"), 1U);
  EXPECT_EQ(rapidsOf("G85"), 0U);
  EXPECT_EQ(rapidsOf("G89 P1"), 0U);
  EXPECT_EQ(rapidsOf("G84"), 0U);
  // In another plane, along its axis.
  const auto aside = placesOf(gcode("G98 G18 G0 X3 Y9 Z5 F60\nG81 X5 Z6 Y-2 R1"));
  ASSERT_EQ(aside.size(), 4U);
  EXPECT_EQ(aside[2], Point3(5, -2, 6));
  EXPECT_EQ(aside[3], Point3(5, 9, 6));
}

TEST(Gcode, CannedCyclesSayWhatTheyLack) {
  const auto error = [](const std::string& text) {
    return refusalOf(gcode("G0 X0 Y0 Z5\nF60\n" + text));
  };
  EXPECT_EQ(error("G81 X1 Z-3"), "a.nc:3: G81 has no R, the height where feed begins");
  EXPECT_EQ(error("G81 X1 R1"), "a.nc:3: G81 has no Z, the bottom");
  EXPECT_EQ(error("G81 X1 Z2 R1"), "a.nc:3: G81: R is 1 mm below Z, the bottom");
  EXPECT_EQ(error("G83 X1 Z-2 R1"), "a.nc:3: G83 has no Q above zero, the depth of a peck");
  EXPECT_EQ(error("G83 X1 Z-2 R1 Q1e-9"),
            "a.nc:3: E-9 is not supported: it is the filament of a 3D printer, or an exponent; "
            "have plain decimal numbers written");
  EXPECT_EQ(error("G83 X1 Z-2 R1 Q.0000001"),
            "a.nc:3: a hole of 3 in steps of Q = 1e-07 has too many of them");
  EXPECT_EQ(error("G81 X1 Z-2 R1 L1.5"), "a.nc:3: G81: L1.5 is not a whole number up to 1000000");
  EXPECT_EQ(error("G81 R1"), "a.nc:3: R1 stands without X, Y or Z");
  EXPECT_EQ(error("G81"), "a.nc:3: G81 stands without X, Y or Z");
  EXPECT_EQ(error("G93 G81 X1 Z-2 R1 F1"), "a.nc:3: G81: a canned cycle has no inverse time (G93)");
}

TEST(Gcode, OriginsLieWhereTheyAreStated) {
  ToolPathOptions options;
  ASSERT_TRUE(parseOffset("G55=10,20,30", options.offsets));
  ASSERT_TRUE(parseOffset("G59.3=-1,0,0", options.offsets));
  const auto path = gcode("G0 X0 Y0 Z0\nG55 X1\nG59.3 X0\nG54 X0 Y0 Z0", options);
  EXPECT_EQ(placesOf(path), (std::vector<Point3>{{11, 0, 0}, {-1, 0, 0}, {0, 0, 0}}));
  // G92 gives the present point coordinates, in all of them, until G92.1.
  EXPECT_EQ(
      placesOf(gcode("G0 X5 Y0 Z0\nG92 X0\nX1\nG55 Y0\nG92.2\nX0\nG92.3\nX0\nG92.1\nX0", options)),
      (std::vector<Point3>{{6, 0, 0}, {6, 20, 0}, {10, 20, 0}, {15, 20, 0}, {10, 20, 0}}));
  EXPECT_EQ(placesOf(gcode("G0 X5 Y0 Z0\nG52 X2\nX0\nG52 X0\nX0")),
            (std::vector<Point3>{{2, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(placesOf(gcode("G0 X5 Y0 Z0\nG10 L20 P1 X0\nX1")), (std::vector<Point3>{{6, 0, 0}}));
  EXPECT_EQ(refusalOf(gcode("G10 L2 P1 X0\nG0 X5 Y0 Z0")),
            "a.nc:1: G10 L2 sets an origin from the zero of the machine; say where that is in the "
            "frame of the stock");
  ASSERT_TRUE(parseOffset("G53=100,0,0", options.offsets));
  EXPECT_EQ(placesOf(gcode("G0 X5 Y0 Z0\nG10 L2 P1 X-100 Y1\nX1", options)),
            (std::vector<Point3>{{1, 0, 0}}));
  for (const char* wrong :
       {"G55", "G55=1,2", "G55=1,2,3,4", "G60=1,2,3", "G59.4=1,2,3", "=1,2,3"}) {
    EXPECT_FALSE(parseOffset(wrong, options.offsets)) << wrong;
  }
}

TEST(Gcode, PlacesOfTheMachineAreWhereTheyAreStated) {
  ToolPathOptions options;
  ASSERT_TRUE(parseOffset("G53=0,0,100", options.offsets));
  ASSERT_TRUE(parseOffset("G30=7,7,-1", options.offsets));
  EXPECT_EQ(placesOf(gcode("G0 X0 Y0 Z0\nG28 Z5\nG53 G0 X1\nG30\nG1 X9 F60", options)),
            (std::vector<Point3>{{0, 0, 5}, {0, 0, 100}, {1, 0, 100}, {7, 7, 99}, {9, 7, 99}}));
  // G28.1 keeps where the machine is.
  EXPECT_EQ(placesOf(gcode("G0 X1 Y2 Z3\nG28.1\nX5\nG28\n")),
            (std::vector<Point3>{{5, 2, 3}, {1, 2, 3}}));
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG91 G53 X1")),
            "a.nc:2: G53 is for absolute positions; give G90 before");
}

TEST(Gcode, TheToolIsOutOfTheWayWhereItsPlaceIsNotKnown) {
  const auto path =
      gcode("G91 G28 Z0\nG90 G0 X0 Y0 Z0\nG28 Z5\nG0 X9\nG53 G0 Y7\nY1 Z3\nG1 X8 F60");
  EXPECT_EQ(placesOf(path), (std::vector<Point3>{{0, 0, 5}, {9, 1, 3}, {8, 1, 3}}));
  ASSERT_EQ(path->notices.size(), 1U);
  EXPECT_EQ(path->notices[0],
            "a.nc:1: 3 moves go to places of the machine (G28, G30, G53) that are not known: the "
            "tool is out of the way until X, Y and Z are given again");
  EXPECT_EQ(path->unknownMoves, 3U);
  ASSERT_EQ(path->mountings.size(), 3U);
  EXPECT_EQ(path->mountings[0].tool, 0);
  EXPECT_EQ(path->mountings[1].tool, std::nullopt);
  EXPECT_EQ(path->mountings[2].tool, 0);
  EXPECT_EQ(path->mountings[1].time, path->motion.segments[0].timeEnd);
  EXPECT_EQ(path->mountings[2].time, path->motion.segments[1].timeEnd);
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG28 Z5\nG0 X9\nG1 X8 F60")),
            "a.nc:4: a cutting move where Z is not known, since line 2 moves to a place of the "
            "machine; give it by G0 before, or say where the machine's zero is");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG28 Z5\nG91 G0 Z1")),
            "a.nc:3: Z is relative (G91) where it is not known, since line 2 moves to a place of "
            "the machine");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG53 G1 X1 F60")),
            "a.nc:2: a cutting move to a place of the machine is not supported where that is not "
            "known");
}

TEST(Gcode, AToolTurnsWhileItIsOutOfTheWay) {
  ToolPathOptions options;
  options.rotaries = {*parseRotaryAxis("A=table")};
  const auto path = gcode("G0 X0 Y0 Z9\nG91 G28 Z0\nG90 G0 A180\nX1 Y0 Z20\nG1 Z19 F60", options);
  EXPECT_NEAR((endOf(path) - Point3(1, 0, -19)).norm(), 0, 1e-12);
  const Eigen::Vector3d axis = path->motion.segments.back().end.rotation * Point3::UnitZ();
  EXPECT_NEAR((axis + Eigen::Vector3d::UnitZ()).norm(), 0, 1e-12);
}

TEST(Gcode, RoundingIsNoMove) {
  // 0.1 + 0.2 is not 0.3.
  const std::string code = "G0 X0.1 Y0 Z0\nG91 X0.2\nG90 X0.3\nG1 X0.3 F60\nX1";
  EXPECT_EQ(placesOf(gcode(code)).size(), 2U);
  ToolPathOptions options;
  options.rotaries = {*parseRotaryAxis("C=table")};
  EXPECT_NEAR(durationOf(gcode("G0 X0.1 Y0 Z0\nG91 X0.2\nG90 G1 X0.3 C90 F90", options)), 60, 0.01);
}

TEST(Gcode, WordsThatPostsWriteForNothingAreRead) {
  EXPECT_EQ(placesOf(gcode("G0 X0 Y0 Z5 A0.\nG2 X2 Y0 Z5 I1 J0 K0.000 F60\n")).back(),
            Point3(2, 0, 5));
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z5\nG2 X2 I1 K1 F60\n")),
            "a.nc:2: K is not in the plane of the arc (G17, G18, G19)");
  // After G80 the move before the cycles is in force, as on Fanuc's controls.
  EXPECT_EQ(heightsOf("G98 G81 X1 Z-3 R1\nG80\nZ9"), (std::vector<double>{5, 1, -3, 5, 9}));
}

TEST(Gcode, ToolsAreThoseThatAreGiven) {
  ToolPathOptions options;
  options.tools = {1, 2};
  const auto path = gcode("T1 M6\nG0 X0 Y0 Z0\nG1 X1 F60\nT2\nX2\nM6\nX3\nT0 M6\nG0 X4", options);
  ASSERT_TRUE(path) << refusalOf(path);
  ASSERT_EQ(path->mountings.size(), 3U);
  EXPECT_EQ(path->mountings[0].tool, 1);
  EXPECT_EQ(path->mountings[1].tool, 2);
  EXPECT_NEAR(path->mountings[1].time, 2, 1e-12);
  EXPECT_EQ(path->mountings[2].tool, std::nullopt);
  EXPECT_EQ(refusalOf(gcode("T1 M6\nG0 X0 Y0 Z0\nT7 M6", options)),
            "a.nc:3: tool 7 is mounted, but not given (tools: 1, 2)");
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG1 X1 F60", options)),
            "a.nc:2: a cutting move comes before a tool is mounted (T1 M6)");
}

TEST(Gcode, LengthsOfToolsShiftTheTip) {
  ToolPathOptions options{.rapidFeed = 600};
  options.tools = {1, 2};
  options.lengths = {{1, {0, 0, 10}}, {2, {0, 0, 25}}};
  // The tip is where it is programmed with G43, and lower by the length without it.
  const auto path = gcode("T1 M6 G43\nG0 X0 Y0 Z0\nX1\nT2 M6\nG43 H2\nZ0\nG49\nG1 Z0 F60", options);
  EXPECT_EQ(placesOf(path), (std::vector<Point3>{{1, 0, 0}, {1, 0, -15}, {1, 0, 0}, {1, 0, -25}}));
  // Nothing is mounted while the tip is another's.
  ASSERT_EQ(path->mountings.size(), 3U);
  EXPECT_EQ(path->mountings[1].tool, std::nullopt);
  EXPECT_EQ(path->mountings[2].tool, 2);
  EXPECT_NEAR(path->mountings[2].time - path->mountings[1].time, 1.5, 1e-12);
  ASSERT_EQ(path->notices.size(), 1U);
  EXPECT_EQ(path->notices[0],
            "a.nc:8: T2 cuts with a length offset of 0 (G43), and is 25 long in the tool table: "
            "its tip is 25 lower than programmed");
  EXPECT_EQ(refusalOf(gcode("T1 M6\nG43 H3\nG0 X0 Y0 Z0", options)),
            "a.nc:2: G43 H3: there is no tool 3 in the tool table");
  EXPECT_EQ(placesOf(gcode("T1 M6 G43.1 Z4\nG0 X0 Y0 Z0\nX1", options)),
            (std::vector<Point3>{{1, 0, -6}}));
}

TEST(Gcode, ExpressionsAreThoseOfLinuxCnc) {
  const auto valueOf = [](const std::string& expression) {
    const auto path = gcode("#1=7 #<a b>=0.5\n#2=8 #[20+1]=21\nG0 X-9 Y0 Z0\nX" + expression);
    EXPECT_TRUE(path) << expression << refusalOf(path);
    return path ? path->motion.segments.back().end.translation.x() : -99;
  };
  const struct {
    const char* text;
    double value;
  } kCases[] = {{"#1", 7},
                {"-#1", -7},
                {"##1", 0},
                {"#21", 21},
                {"#<AB>", 0.5},
                {"[1+2*3]", 7},
                {"[[1+2]*3]", 9},
                {"[2**3**2]", 64},
                {"[2*3**2]", 18},
                {"[10-4-3]", 3},
                {"[7 MOD 4]", 3},
                {"[-7 MOD 4]", 1},
                {"[1 LT 2 AND 3 GE 4]", 0},
                {"[1 EQ 1.0000001 OR 0]", 1},
                {"[1 XOR 1]", 0},
                {"[1 NE 2]", 1},
                {"sqrt[16]", 4},
                {"atan[1]/[-1]", 135},
                {"[sin[30]*2]", 1},
                {"[cos[60]]", 0.5},
                {"tan[45]", 1},
                {"asin[1]", 90},
                {"acos[0]", 90},
                {"exp[0]", 1},
                {"ln[1]", 0},
                {"abs[-3]", 3},
                {"fix[-2.5]", -3},
                {"fup[2.1]", 3},
                {"round[2.5]", 3},
                {"exists[#<ab>]", 1},
                {"exists[#<_none>]", 0},
                {"#5220", 1}};
  for (const auto& [text, value] : kCases) EXPECT_NEAR(valueOf(text), value, 1e-9) << text;
}

TEST(Gcode, ExpressionsSayWhatIsWrong) {
  const auto error = [](const std::string& text) {
    return refusalOf(gcode("G0 X0 Y0 Z0\n" + text));
  };
  EXPECT_EQ(error("X[1+2"), "a.nc:2: the line ends, expected an operator or ]");
  EXPECT_EQ(error("X[1 2 G]"), "a.nc:2: found 'G]', expected an operator or ]");
  EXPECT_EQ(error("X[1/0]"), "a.nc:2: 1 / 0 is not a number");
  EXPECT_EQ(error("Xsqrt[-1]"), "a.nc:2: SQRT[-1] is not a number");
  EXPECT_EQ(error("X#<depth>"), "a.nc:2: #<DEPTH> has not been set");
  EXPECT_EQ(error("X#6000"), "a.nc:2: #6000 is not a parameter: they have the numbers 1 to 5602");
  EXPECT_EQ(error("#5221=3"),
            "a.nc:2: #5221 cannot be set: it is a value of the control; offsets are set by G10 "
            "and G92");
  EXPECT_EQ(error("X#5061"),
            "a.nc:2: #5061 is not supported: it is a value of the control that is not known here, "
            "or not yet");
  EXPECT_EQ(error("#1"), "a.nc:2: a parameter stands without a letter before it or = after it");
  EXPECT_EQ(error("X" + std::string(1'000'000, '[')),
            "a.nc:2: brackets, signs and functions are more than 100 deep");
  EXPECT_EQ(error("Xatan[1]"),
            "a.nc:2: the line ends, expected / and the second number of ATAN in brackets");
}

TEST(Gcode, LoopsAndBranchesFollowTheirConditions) {
  const std::string start = "G0 X0 Y0 Z0\nG91 F60\n";
  const auto xOf = [&](const std::string& text) { return endOf(gcode(start + text)).x(); };
  EXPECT_EQ(xOf("O1 repeat [3]\nG1 X1\nO1 endrepeat"), 3);
  EXPECT_EQ(xOf("X1\nO1 repeat [0]\nG1 X1\nO1 endrepeat"), 1);
  EXPECT_EQ(xOf("#1=0\no1 while [#1 lt 4]\nG1 X1\n#1=[#1+1]\no1 endwhile"), 4);
  EXPECT_EQ(xOf("#1=9\no1 do\nG1 X1\n#1=[#1+1]\no1 while [#1 lt 4]\nX1"), 2);
  EXPECT_EQ(xOf("#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\n"
                "o3 if [#1 gt 5]\no1 break\no3 endif\nX1\no1 endwhile"),
            4);
  const auto branch = [&](int value) {
    return xOf(
        fmt::format("#1={}\nO5 if [#1 EQ 1]\nX1\nO5 elseif [#1 EQ 2]\nX2\nO5 elseif [#1 EQ "
                    "3]\nX3\nO5 else\nX4\nO5 endif\nX10",
                    value));
  };
  EXPECT_EQ(branch(1), 11);
  EXPECT_EQ(branch(2), 12);
  EXPECT_EQ(branch(3), 13);
  EXPECT_EQ(branch(7), 14);
}

TEST(Gcode, SubprogramsHaveParametersOfTheirOwn) {
  const std::string start = "G0 X0 Y0 Z0\nG91 F60\n";
  const auto xOf = [&](const std::string& text) { return endOf(gcode(start + text)).x(); };
  EXPECT_EQ(xOf("O100 sub\nX#1\n#1=50 #31=4\nO100 endsub\n#1=2\nO100 call [#1+1]\nX#1\nX#31"), 9);
  // Recursion, a value that is returned, and a subprogram after the end of the program.
  EXPECT_EQ(xOf("o<fac> call [5]\nX#<_value>\nM2\no<fac> sub\no1 if [#1 LE 1]\no<fac> return [1]\n"
                "o1 endif\no<fac> call [#1-1]\no<fac> endsub [#1*#<_value>]"),
            120);
  // Fanuc's.
  EXPECT_EQ(xOf("M98 P100 L3\nX1\nM30\nO0100\nX2\nM98 P200\nM99\nO200\nX10\nM99\n"), 37);
  EXPECT_EQ(xOf("O1 (main)\nX1\nM98 P2\nM30\nO2\nX5\nM99"), 6);
  EXPECT_EQ(xOf("O2\nX5\nM99\nO1\nX1\nM98 P2\nM30"), 6);
}

TEST(Gcode, ProgramsThatDoNotEndOrNestAreRefused) {
  const auto error = [](const std::string& text) {
    return refusalOf(gcode("G0 X0 Y0 Z0\nG1 X1 F60\n" + text));
  };
  EXPECT_EQ(error("o1 while [1]\no1 endwhile"),
            "a.nc:3: 5000004 lines have been carried out, 5000000 more than the program has; it "
            "may never end");
  EXPECT_EQ(error("o1 sub\no1 call\no1 endsub\no1 call"),
            "a.nc:4: subprograms call each other more than 100 deep");
  EXPECT_EQ(error("o1 if [1]\n"), "a.nc:3: O1 begins here and has no end");
  EXPECT_EQ(error("o1 if [1]\no2 endif\n"),
            "a.nc:4: O2 ends or goes on here without its beginning; open is O1, from line 3");
  EXPECT_EQ(error("o<x> endwhile\n"),
            "a.nc:3: O<X> ends or goes on here without its beginning; no block is open");
  EXPECT_EQ(error("o1 break\n"), "a.nc:3: O1: there is no loop of this name here");
  EXPECT_EQ(error("o1 sub\no1 endsub\no1 sub\no1 endsub"),
            "a.nc:5: O1 is a second subprogram of this name; the first is in line 3");
  EXPECT_EQ(error("o1 call"),
            "a.nc:3: O1 is called, and the file has no O1 sub; put the subprogram into it");
  EXPECT_EQ(error("M98 P7"),
            "a.nc:3: M98 calls P7, and no line O7 begins a subprogram; repeats are given by L");
  EXPECT_EQ(error("o1 sub\nM99\no1 endsub\no1 call"),
            "a.nc:4: M99 stands in a subprogram that M98 did not call");
  EXPECT_EQ(error("M98 P7 L3\nM30\nO7\nG0 X1"),
            "a.nc:5: the subprogram that begins here is called in line 3 and has no end (M99)");
  EXPECT_EQ(placesOf(gcode("%\nG0 X0 Y0 Z0\nX1\n%\nX2\n")), (std::vector<Point3>{{1, 0, 0}}));
}

TEST(Gcode, ATableTurnsTheStockUnderTheTool) {
  // C turns by a quarter: the tool goes round the stock the positive way.
  ToolPathOptions options{.tolerance = 1e-4};
  options.rotaries = {*parseRotaryAxis("C=table:1,0,0")};
  const auto path = gcode("G0 X11 Y0 Z0\nG1 C90 F90", options);
  EXPECT_NEAR((endOf(path) - Point3(1, 10, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(durationOf(path), 60, 1e-9);
  EXPECT_NEAR(lengthOf(path), 5 * std::numbers::pi, 1e-3);
  for (const auto& segment : path->motion.segments) {
    const Point3 middle = 0.5 * (segment.start.translation + segment.end.translation);
    EXPECT_LE(10 - (middle - Point3(1, 0, 0)).norm(), 1e-4);
  }
  options.rotaries = {*parseRotaryAxis("C=-table:1,0,0")};
  EXPECT_NEAR((endOf(gcode("G0 X11 Y0 Z0\nG1 C90 F90", options)) - Point3(1, -10, 0)).norm(), 0,
              1e-12);
}

TEST(Gcode, AHeadTiltsTheToolAboutItsPivot) {
  ToolPathOptions options;
  options.rotaries = {*parseRotaryAxis("B=head:0,0,100")};
  const auto path = gcode("G0 X0 Y0 Z0\nG93\nG1 B90 F2", options);
  // The tip was below the pivot, and is beside it.
  EXPECT_NEAR((endOf(path) - Point3(-100, 0, 100)).norm(), 0, 1e-9);
  EXPECT_NEAR(durationOf(path), 30, 1e-9);
  EXPECT_NEAR(
      (path->motion.segments.back().end.rotation * Point3::UnitZ() - Point3::UnitX()).norm(), 0,
      1e-9);
  // With the tip under control it stays.
  const auto controlled = gcode("G0 X1 Y2 Z3\nG43.4\nG1 B30 F60\nG49\nG1 Z10", options);
  ASSERT_TRUE(controlled) << refusalOf(controlled);
  bool isStill = true;
  for (const auto& segment : controlled->motion.segments) {
    if (segment.screw.angleDegrees == 0) continue;
    isStill = isStill && (segment.end.translation - Point3(1, 2, 3)).norm() < 1e-9;
  }
  EXPECT_TRUE(isStill);
}

TEST(Gcode, TwoRotaryAxesCarryEachOther) {
  // Table and table, A carries C: a point of the stock and the axis of the tool, against the
  // product of the rotations.
  ToolPathOptions options{.tolerance = 1e-3};
  options.rotaries = {*parseRotaryAxis("A=table:0,0,-50"), *parseRotaryAxis("C=table")};
  const auto path = gcode("G0 X10 Y0 Z0\nG93 G1 X20 Y5 Z30 A30 C40 F1", options);
  const auto turn = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis).toRotationMatrix();
  };
  for (const auto& segment : path->motion.segments) {
    const double part = segment.timeEnd / 60;
    const Eigen::Matrix3d a = turn(30 * part, Eigen::Vector3d::UnitX());
    const Eigen::Matrix3d c = turn(40 * part, Eigen::Vector3d::UnitZ());
    const Point3 machine(10 + 10 * part, 5 * part, 30 * part);
    const Point3 pivot(0, 0, -50);
    const Point3 tip = c * (pivot + a * (machine - pivot));
    EXPECT_NEAR((segment.end.translation - tip).norm(), 0, 1e-9);
    EXPECT_NEAR((segment.end.rotation * Point3::UnitZ() - c * a * Point3::UnitZ()).norm(), 0, 1e-9);
  }
  EXPECT_GT(path->motion.segments.size(), 10U);
  for (const char* wrong : {"A", "A=", "D=table", "A=bench", "A=table:1,2", "A=table:1,2,3,4"}) {
    EXPECT_FALSE(parseRotaryAxis(wrong)) << wrong;
  }
  EXPECT_EQ(refusalOf(gcode("G0 X0 Y0 Z0\nG93 G1 X1", options)),
            "a.nc:2: a cutting move with inverse time (G93) has no F in its line");
}

TEST(ToolTable, HasLengthsAndRemarks) {
  const auto table = readToolTable(InputFile{
      "a.tbl", ";a comment\nT1 P1 D6 Z+50.8 ;flat:d=6,l=20\r\n\nT20 p2 x-1 Y2.5 Z0;drill:d=3\n"});
  ASSERT_TRUE(table) << table.error().text();
  ASSERT_EQ(table->size(), 2U);
  EXPECT_EQ(table->at(1).length, Eigen::Vector3d(0, 0, 50.8));
  EXPECT_EQ(table->at(1).remark, "flat:d=6,l=20");
  EXPECT_EQ(table->at(20).length, Eigen::Vector3d(-1, 2.5, 0));
  EXPECT_EQ(table->at(20).remark, "drill:d=3");
  const auto error = [](const std::string& text) {
    const auto read = readToolTable(InputFile{"a.tbl", text});
    return read ? "no error" : read.error().text();
  };
  EXPECT_EQ(error("T1 Z5\nT1 Z6"), "a.tbl:2: T1 comes a second time");
  EXPECT_EQ(error("P1 Z5"), "a.tbl:1: the line has no T, the number of the tool");
  EXPECT_EQ(error("T1 Zx"),
            "a.tbl:1: found 'Zx', expected T, P, X, Y, Z or D and a number, as in T1 P1 Z50.8 D6 "
            ";a remark");
  EXPECT_EQ(error("T1.5"), "a.tbl:1: 'T1.5' is not the number of a tool");
  EXPECT_EQ(error("; nothing"), "a.tbl: holds no tool");
}

TEST(CutterLocations, ToolsAreThoseThatAreGiven) {
  ToolPathOptions options;
  options.tools = {1, 2};
  const auto read = [&](const std::string& text) {
    return readCutterLocations(InputFile{"a.cl", text}, options);
  };
  const auto path =
      read("FEDRAT/60\nLOADTL/1\nGOTO/0,0,0\nGOTO/1,0,0\nLOADTL/2,ADJUST,2\nGOTO/2,0,0");
  ASSERT_TRUE(path) << refusalOf(path);
  ASSERT_EQ(path->mountings.size(), 2U);
  EXPECT_EQ(path->mountings[0].tool, 1);
  EXPECT_EQ(path->mountings[1].tool, 2);
  EXPECT_NEAR(path->mountings[1].time, 1, 1e-12);
  EXPECT_EQ(refusalOf(read("LOADTL/7")), "a.cl:1: tool 7 is mounted, but not given (tools: 1, 2)");
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
