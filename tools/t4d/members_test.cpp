#include "tools/t4d/members.h"

#include <limits>

#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct Part {
  std::string name = "wheel";
  double radius = 0;
};

struct Report {
  std::uint64_t cells = 3;
  std::optional<double> error = {};
  model::Point3 place = {1, 2, 3};
  std::string kind = "solid";
  std::vector<Part> parts = {};
  std::map<std::string, bool> flags = {};
  bool asked = false;
  std::optional<double> limit = {};
};

void describe(Members& members, const Report& report) {
  members("cells", report.cells, "Cells.").joined(Joined::Added);
  members("error", report.error, "Of all.").atLeast(0).joined(Joined::Most);
  members("place", report.place, "Where.").itemsOrNull();
  members("kind", report.kind, "Which.").oneOf({"solid", "cavity"});
  members("parts", report.parts, "Each.", [](Members& own, const Part& part) {
    own("name", part.name, "Its name.").notEmpty();
    own("radius", part.radius, "Half its width.").above(0).orNull();
  }).onlyIf(!report.parts.empty());
  members("flags", report.flags, "By name.");
  members("asked", report.asked, "Null unless it was.").nullIf(!report.asked);
  members.ifKnown("limit", report.limit, "If there is one.").above(0);
}

TEST(Members, AreTheJsonOfAReport) {
  EXPECT_EQ(
      Members::valueOf(Report()).dump(),
      R"({"cells":3,"error":null,"place":[1.0,2.0,3.0],"kind":"solid","flags":{},"asked":null})");
  Report report;
  report.error = 0.5;
  report.parts = {{.name = "axle", .radius = std::numeric_limits<double>::infinity()}};
  report.flags["big"] = true;
  report.asked = true;
  report.limit = 2;
  EXPECT_EQ(
      Members::valueOf(report).dump(),
      R"({"cells":3,"error":0.5,"place":[1.0,2.0,3.0],"kind":"solid",)"
      R"("parts":[{"name":"axle","radius":null}],"flags":{"big":true},"asked":true,"limit":2.0})");
}

TEST(Members, AreTheSchemaOfAReport) {
  const auto expected = ordered_json::parse(R"({
    "type": "object",
    "properties": {
      "cells": {"type": "integer", "minimum": 0, "description": "Cells."},
      "error": {"type": ["number", "null"], "description": "Of all.", "minimum": 0},
      "place": {"type": "array", "items": {"type": ["number", "null"]}, "minItems": 3,
                "maxItems": 3, "description": "Where."},
      "kind": {"description": "Which.", "enum": ["solid", "cavity"]},
      "parts": {"type": "array", "items": {
        "type": "object",
        "properties": {
          "name": {"type": "string", "description": "Its name.", "minLength": 1},
          "radius": {"type": ["number", "null"], "description": "Half its width.",
                     "exclusiveMinimum": 0}
        },
        "required": ["name", "radius"],
        "additionalProperties": false
      }, "description": "Each."},
      "flags": {"type": "object", "additionalProperties": {"type": "boolean"},
                "description": "By name."},
      "asked": {"type": ["boolean", "null"], "description": "Null unless it was."},
      "limit": {"type": "number", "description": "If there is one.", "exclusiveMinimum": 0}
    },
    "required": ["cells", "error", "place", "kind", "flags", "asked"],
    "additionalProperties": false
  })");
  EXPECT_EQ(nlohmann::json(Members::schemaOf<Report>()), nlohmann::json(expected));
}

TEST(Members, AreJoinedByTheRulesThatTheyHave) {
  EXPECT_EQ(rulesOf<Report>(), (JoinRules{{"cells", Joined::Added}, {"error", Joined::Most}}));
}

}  // namespace
}  // namespace t4d::tools
