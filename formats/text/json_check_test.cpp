#include "formats/text/json_check.h"

#include <array>

#include <gtest/gtest.h>

namespace t4d::formats {
namespace {

std::string faultOf(std::string_view text) {
  static constexpr std::array<std::string_view, 1> kWhole = {"offset"};
  const auto checked = checkJson(text, "a.json", {.deepestNesting = 3, .wholeNumbers = kWhole});
  return checked ? "" : checked.error().text();
}

TEST(JsonCheck, FindsAKeyThatOccursTwiceInOneObject) {
  EXPECT_EQ(faultOf(R"({"a": 1, "b": {"a": 2}, "c": [{"a": 1}, {"a": 2}]})"), "");
  EXPECT_EQ(faultOf(R"({"b": {"a": 1, "c": {}, "a": 1}})"),
            "a.json: has the key 'a' twice in one object");
}

TEST(JsonCheck, WantsWholeNumbersWhereToldTo) {
  EXPECT_EQ(faultOf(R"({"offset": 3, "other": -3, "list": [-1, 0.5]})"), "");
  for (const char* value : {"-3", "0.5", "null", "true", "\"3\"", "{}", "[]"}) {
    EXPECT_NE(faultOf(std::string(R"({"a": [{"offset": )") + value + "}]}")
                  .find("expected a whole number from 0 on"),
              std::string::npos)
        << value;
  }
}

TEST(JsonCheck, LimitsNesting) {
  EXPECT_EQ(faultOf("[[[]]]"), "");
  EXPECT_EQ(faultOf("[[[[]]]]"), "a.json: has JSON nested more than 3 levels deep");
  EXPECT_NE(faultOf(std::string(1'000'000, '[')), "");
}

TEST(JsonCheck, LeavesOtherFaultsToTheParser) {
  for (const char* text : {"", "{", "{\"a\"", "nonsense", "[1,]"}) EXPECT_EQ(faultOf(text), "");
}

}  // namespace
}  // namespace t4d::formats
