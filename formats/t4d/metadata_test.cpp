#include "formats/t4d/metadata.h"

#include <gmock/gmock.h>

#include "formats/t4d/layout.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using testing::HasSubstr;

std::string faultOfHead(const std::string& text) {
  const auto head = parseHead(text);
  return head ? "" : head.error().message;
}

TEST(Metadata, ComesBack) {
  Metadata metadata;
  metadata.generator = "a \"program\" 1.0";
  metadata.backend = "mesh4d";
  metadata.lengthUnit = "mm";
  metadata.timeUnit = "s";
  metadata.up = "z";
  metadata.bodies = {{"gear", {0.5, 0.25, 1, 1}, "steel", "Zahnrad \u00e4", R"({"teeth":12})"},
                     {"Zahnrad \u00e4"}};
  metadata.detailsJson = R"({"source":{"file":"gear.stl","triangles":12},"steps":[1,2.5,null]})";
  const auto text = headText(metadata, {"zstd", "means"});
  ASSERT_TRUE(text) << text.error().text();
  const auto read = parseHead(*text);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->generator, metadata.generator);
  EXPECT_EQ(read->backend, metadata.backend);
  EXPECT_EQ(read->lengthUnit, metadata.lengthUnit);
  EXPECT_EQ(read->timeUnit, metadata.timeUnit);
  EXPECT_EQ(read->up, metadata.up);
  ASSERT_EQ(read->bodies.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read->bodies[i].name, metadata.bodies[i].name);
    EXPECT_EQ(read->bodies[i].color, metadata.bodies[i].color);
    EXPECT_EQ(read->bodies[i].material, metadata.bodies[i].material);
    EXPECT_EQ(read->bodies[i].parent, metadata.bodies[i].parent);
    EXPECT_EQ(read->bodies[i].detailsJson, metadata.bodies[i].detailsJson);
  }
  EXPECT_EQ(read->detailsJson, metadata.detailsJson);
}

TEST(Metadata, LeavesOutWhatIsNotKnownAndIgnoresUnknownMembers) {
  const auto read = parseHead(R"({"features":[],"bodies":[{"name":"b"}],"a later member":[1]})");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->generator, "");
  EXPECT_EQ(read->lengthUnit, "");
  EXPECT_EQ(read->up, "y");
  EXPECT_EQ(read->detailsJson, "{}");
}

TEST(Metadata, AttributesOfAnotherFormAreNotKnown) {
  for (const char* attributes : {"{}", "[]", "3", R"([{"kind":"vector"}])", R"({"v":[]})"}) {
    const auto read = parseHead(R"({"features":[],"bodies":[{"name":"b"}],"attributes":)" +
                                std::string(attributes) + "}");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_TRUE(read->attributes.empty()) << attributes;
    // They stay what they are, as other members that are not known do.
    auto again = headText(*read, {});
    ASSERT_TRUE(again);
    std::erase_if(*again, [](char letter) { return letter == ' ' || letter == '\n'; });
    EXPECT_THAT(*again, HasSubstr(std::string("\"attributes\":") + attributes));
  }
}

TEST(Metadata, RefusesUnknownFeaturesByName) {
  const auto read = parseHead(R"({"features":["zstd","wavelets"],"bodies":[{"name":"b"}]})");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(read.error().message, HasSubstr("'wavelets'"));
}

TEST(Metadata, RefusesWhatIsNotAHead) {
  for (const char* text : {"", "[]", "{", "null", "{\"features\":[],\"bodies\":[\"\xff\"]}"}) {
    EXPECT_THAT(faultOfHead(text), HasSubstr("not a JSON object")) << text;
  }
  EXPECT_THAT(faultOfHead(R"({"bodies":[{"name":"b"}]})"), HasSubstr("'features'"));
  EXPECT_THAT(faultOfHead(R"({"features":{},"bodies":[{"name":"b"}]})"), HasSubstr("'features'"));
  EXPECT_THAT(faultOfHead(R"({"features":[1],"bodies":[{"name":"b"}]})"),
              HasSubstr("not a string"));
  EXPECT_THAT(faultOfHead(R"({"features":[]})"), HasSubstr("'bodies'"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[]})"), HasSubstr("0 bodies"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":""}]})"), HasSubstr("has 0 bytes"));
  EXPECT_THAT(
      faultOfHead(R"({"features":[],"bodies":[{"name":")" + std::string(256, 'x') + "\"}]}"),
      HasSubstr("has 256 bytes"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":"b"},{"name":"b"}]})"),
              HasSubstr("twice"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":"b"}],"up":"x"})"),
              HasSubstr("'up'"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":"b"}],"generator":1})"),
              HasSubstr("'generator'"));
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":"b"}],"details":1})"),
              HasSubstr("'details'"));
}

TEST(Metadata, SaysWhichByteIsWrong) {
  const std::string right = R"({"features":[],"bodies":[{"name":"b"}]})";
  const auto offsetOf = [](const std::string& text) { return parseHead(text).error().offset; };
  EXPECT_EQ(offsetOf(right + " {}"), right.size() + 1);
  EXPECT_EQ(offsetOf(R"({"features":[],})"), 15);
  // To the JSON library a zero byte is the end of the text.
  EXPECT_EQ(offsetOf(right + '\0'), right.size());
  EXPECT_THAT(faultOfHead(R"({"features":[],"bodies":[{"name":"b"}],"details":{"a":1e999}})"),
              HasSubstr("binary64"));
}

TEST(Metadata, StandsJsonMadeToFillTheStackOrTheDay) {
  const auto nested = [](std::size_t depth) {
    return R"({"features":[],"bodies":[{"name":"b"}],"details":{"a":)" + std::string(depth, '[') +
           std::string(depth, ']') + "}}";
  };
  EXPECT_EQ(faultOfHead(nested(t4d_layout::kMaxJsonDepth - 2)), "");
  EXPECT_THAT(faultOfHead(nested(t4d_layout::kMaxJsonDepth - 1)), HasSubstr("levels"));
  EXPECT_THAT(faultOfHead(nested(4'000'000)), HasSubstr("levels"));
  std::string wide = R"({"features":[],"bodies":[{"name":"b"}],"details":{)";
  for (int i = 0; i < 200'000; ++i) wide += "\"k" + std::to_string(i) + "\":0,";
  EXPECT_EQ(faultOfHead(wide + "\"last\":0}}"), "");
  std::string many = R"({"features":[],"bodies":[{"name":"b"}],"details":{"a":[)";
  for (int i = 0; i < 2'000'000; ++i) many += "{},";
  EXPECT_EQ(faultOfHead(many + "{}]}}"), "");
}

TEST(Metadata, CountsNoBracketsInStrings) {
  std::string name;
  for (int i = 0; i < 80; ++i) name += R"([{\")";
  EXPECT_EQ(faultOfHead(R"({"features":[],"bodies":[{"name":")" + name + R"("}]})"), "");
}

TEST(Metadata, RefusesDetailsThatAreNoObject) {
  Metadata metadata;
  metadata.bodies = {{"b"}};
  for (const char* details : {"", "[]", "{", "1"}) {
    metadata.detailsJson = details;
    EXPECT_FALSE(headText(metadata, {})) << details;
  }
}

}  // namespace
}  // namespace t4d::formats
