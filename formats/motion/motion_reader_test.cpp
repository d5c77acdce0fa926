#include <gtest/gtest.h>

#include "t4d/motion.h"

namespace t4d::formats {
namespace {

TEST(MotionReader, RefusesAKeyThatComesTwice) {
  const auto twice = parseMotion(
      R"({"poses": [{"time": 0}, {"time": 1, "rotation": [0, 0, 0, 1], "time": 2}]})", "m.json");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().text(), "m.json: has the key 'time' twice in one object");
}

TEST(MotionReader, ReadsSegmentsWithTheirDefaults) {
  const auto motion = parseMotion(R"({
    "length_unit": "mm", "time_unit": "s", "start_time": 2,
    "segments": [
      {"duration": 1},
      {"duration": 2, "translation": [0, 0, 1], "repeat": 3},
      {"duration": 4, "axis_point": [1, 0, 0], "axis_direction": [0, 0, 5], "angle_degrees": 90}
    ]})",
                                  "m.json");
  ASSERT_TRUE(motion) << motion.error().text();
  EXPECT_EQ(motion->lengthUnit, "mm");
  EXPECT_EQ(motion->timeUnit, "s");
  ASSERT_EQ(motion->segments.size(), 5U);
  EXPECT_EQ(motion->timeBegin(), 2);
  EXPECT_EQ(motion->timeEnd(), 13);
  EXPECT_EQ(motion->at(9)(model::Point3(2, 0, 0)), model::Point3(2, 0, 3));
  EXPECT_EQ(motion->at(13)(model::Point3(2, 0, 0)), model::Point3(1, 1, 3));
}

TEST(MotionReader, ReadsPosesWithQuaternionsAsInGltf) {
  const auto motion = parseMotion(
      R"({"poses": [{"time": 0}, {"time": 2, "position": [1, 2, 3], "quaternion": [0, 0, 1, 0]}]})",
      "m.json");
  ASSERT_TRUE(motion) << motion.error().text();
  // x y z w = 0 0 1 0 is half a turn about z.
  EXPECT_EQ(motion->at(2)(model::Point3(1, 0, 0)), model::Point3(0, 2, 3));
}

TEST(MotionReader, EveryFaultIsNamedWithItsPlace) {
  struct Case {
    const char* text;
    const char* expected;
  };
  const Case cases[] = {
      {"", "m.json: is not JSON"},
      {"{\"segments\": [", "m.json: is not JSON: parse error at line 1, column 15"},
      {"[]", "m.json: motion: is an array of 0 values, where an object is expected"},
      {"{}", "m.json: motion: lacks the key 'segments' or 'poses'"},
      {R"({"segments": []})", "no segment"},
      {R"({"segments": {}})", "motion.segments: is an object, where an array is expected"},
      {R"({"segments": [{}]})", "motion.segments[0]: lacks the key 'duration'"},
      {R"({"segments": [{"duration": "1"}]})",
       "motion.segments[0].duration: is \"1\", where a number is expected"},
      {R"({"segments": [{"duration": 0}]})", "m.json: segment 0 (counted from 0): lasts 0"},
      {R"({"segments": [{"duration": -3}]})", "backward through time"},
      {R"({"segments": [{"duration": 1, "angel_degrees": 3}]})",
       "motion.segments[0]: has the unknown key 'angel_degrees'; known are duration, axis_point"},
      {R"({"segment": []})", "motion: has the unknown key 'segment'"},
      {R"({"segments": [{"duration": 1, "angle_degrees": 3}]})",
       "motion.segments[0]: lacks the key 'axis_direction'"},
      {R"({"segments": [{"duration": 1, "angle_degrees": 3, "axis_direction": [0, 0, 0]}]})",
       "axis_direction of length 0"},
      {R"({"segments": [{"duration": 1, "translation": [0, 0]}]})",
       "motion.segments[0].translation: is an array of 2 values, where an array of 3 numbers"},
      {R"({"segments": [{"duration": 1, "translation": [0, 0, null]}]})",
       "motion.segments[0].translation[2]: is null, where a number is expected"},
      {R"({"segments": [{"duration": 1, "repeat": 0}]})", "repeats 0 times"},
      {R"({"segments": [{"duration": 1, "repeat": -1}]})", "whole number from 1 on"},
      {R"({"segments": [{"duration": 1, "repeat": 1.5}]})", "whole number from 1 on"},
      {R"({"segments": [{"duration": 1e999}]})", "is not JSON"},
      {R"({"length_unit": 3, "segments": [{"duration": 1}]})", "where text is expected"},
      {R"({"poses": [{"time": 0}], "segments": []})", "both 'poses' and 'segments'"},
      {R"({"poses": [{"time": 0}, {"time": 1}], "start_time": 1})",
       "both 'poses' and 'start_time'"},
      {R"({"poses": [{"time": 0}]})", "at least two"},
      {R"({"poses": [{"time": 0}, {"time": 1, "quaternion": [0, 0, 0, 2]}]})", "length 2, not 1"},
  };
  for (const Case& one : cases) {
    const auto motion = parseMotion(one.text, "m.json");
    ASSERT_FALSE(motion) << one.text;
    EXPECT_EQ(motion.error().code, ErrorCode::InvalidInput);
    EXPECT_NE(motion.error().text().find(one.expected), std::string::npos) << one.text << "\n"
                                                                           << motion.error().text();
  }
}

TEST(MotionReader, DeepNestingIsNoDanger) {
  const std::string deep =
      R"({"segments": )" + std::string(200'000, '[') + std::string(200'000, ']') + "}";
  EXPECT_FALSE(parseMotion(deep, "m.json"));
}

TEST(MotionReader, MissingFileIsAnIoError) {
  const auto motion = readMotion("/nowhere/motion.json");
  ASSERT_FALSE(motion);
  EXPECT_EQ(motion.error().code, ErrorCode::Io);
}

}  // namespace
}  // namespace t4d::formats
