#include <fmt/format.h>

#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"

/// Faults of HEAD.
namespace t4d::conformance {
namespace {

using namespace std::string_literals;

std::string nested(int levels, char open, char close) {
  return std::string(levels, open) + std::string(levels, close);
}

}  // namespace

void addHeadFaults(InvalidCases& cases) {
  const Base base = plain();
  const std::string right = headJson({}, {"simplex"});
  /// A file with a different HEAD, with the fault at `mark`.
  const auto add = [&](const std::string& name, const std::string& fault, const std::string& json,
                       const std::string& mark = "") {
    const std::size_t at = mark.empty() ? 0 : json.find(mark);
    cases.add(
        name, fault, base,
        [&](Image& image) {
          image = Image::of({{"simplex", simplex()}}, {}, json);
        },
        "HEAD/json", at);
  };
  /// Adds a case whose HEAD has additional members.
  const auto with = [&](const std::string& name, const std::string& fault,
                        const std::string& members, const std::string& mark = "") {
    add(name, fault, headJson({}, {"simplex"}, members), mark.empty() ? members : mark);
  };

  constexpr std::size_t kLimit = std::size_t{16} << 20;
  cases.add(
      "M1-16-MiB-and-a-byte", "HEAD is a byte longer than 16 MiB: white space.", base,
      [&](Image& image) {
        image = Image::of({{"simplex", simplex()}}, {},
                          right + std::string(kLimit + 1 - right.size(), ' '));
      },
      "HEAD/header/length");
  add("M2-byte-order-mark", "A byte order mark stands before the object.", "\xEF\xBB\xBF" + right);
  std::string wide = "\xFF\xFE";
  for (const char character : right) wide += {character, '\0'};
  add("M2-utf-16", "The text is in UTF-16.", wide);
  for (const auto& [name, what, bytes] : notUtf8()) {
    with(fmt::format("M2-{}", name), fmt::format("A string has {}.", what),
         "\"details\":{\"a\":\"b" + bytes + "\"}", bytes);
  }
  add("M2-in-body-name", "A body's name is in Latin-1.",
      "{\"features\":[],\"bodies\":[\"W\xFCrfel\"]}", "\xFC");

  add("M3-empty", "The payload has no bytes.", "\n"s.substr(1));
  add("M3-white-space", "There is nothing but white space.", " \n ");
  add("M3-array", "The text is an array.", "[" + right + "]");
  add("M3-string", "The text is a string.", R"("features")");
  add("M3-null", "The text is null.", "null");
  add("M3-two-objects", "Another object follows the object.", right + "{}", "{}");
  add("M3-zero-byte-after", "A zero byte follows the object.", right + "\0"s, "\0"s);
  add("M3-cut-off", "The object is not closed.", right.substr(0, right.size() - 1) + " ", " ");
  add("M3-comma-at-the-end", "A comma stands before the closing brace.",
      right.substr(0, right.size() - 1) + ",}", ",}");
  with("M3-comma-at-the-end-of-array", "A comma stands before the closing bracket.",
       R"("details":{"a":[1,]})", ",]");
  with("M3-comment", "There is a comment.", R"("up":"y"/*up*/)", "/*");
  add("M3-single-quotes", "Strings are in single quotes.", "{'features':[],'bodies':['simplex']}",
      "'");
  with("M3-name-without-quotes", "A member's name is not in quotes.", "up:\"y\"");
  with("M3-nan", "A number is NaN.", R"("details":{"a":NaN})", "NaN");
  with("M3-infinity", "A number is Infinity.", R"("details":{"a":-Infinity})", "-Inf");
  with("M3-leading-zero", "A number begins with a zero.", R"("details":{"a":01})", "01");
  with("M3-plus", "A number begins with a plus.", R"("details":{"a":+1})", "+1");
  with("M3-no-digit-after-point", "A number ends with its point.", R"("details":{"a":1.})", "1.");
  with("M3-no-digit-before-point", "A number begins with its point.", R"("details":{"a":.5})",
       ".5");
  with("M3-hexadecimal", "A number is hexadecimal.", R"("details":{"a":0x10})", "0x10");
  with("M3-true-in-upper-case", "A literal is called True.", R"("details":{"a":True})", "True");
  with("M3-control-character", "A string has a line end in it.", "\"details\":{\"a\":\"b\nc\"}",
       "\n");
  with("M3-zero-byte-in-string", "A string has a zero byte in it.", "\"details\":{\"a\":\"b\0c\"}"s,
       "\0"s);
  with("M3-unknown-escape", "A string has an escape that JSON does not have.",
       R"("details":{"a":"\x41"})", "\\x");
  with("M3-escape-cut-off", "An escape has three digits.", R"("details":{"a":"\u041"})", "\\u");
  with("M3-form-feed", "A form feed stands between members.", "\f\"up\":\"y\"", "\f");
  with("M3-no-break-space", "A no-break space stands between members.", "\xC2\xA0\"up\":\"y\"",
       "\xC2\xA0");
  with("M3-colon-missing", "A member has no colon.", R"("up" "y")", "\"y\"");
  with("M3-wrong-bracket", "An array is closed with a brace.", R"("details":{"a":[1}})", "}}");

  with("M4-65-levels-of-arrays", "Arrays are 65 levels deep.",
       "\"details\":{\"a\":" + nested(63, '[', ']') + "}", "[]");
  std::string objects = "{}";
  for (int level = 64; level >= 2; --level) objects = "{\"a\":" + objects + "}";
  with("M4-65-levels-of-objects", "Objects are 65 levels deep.", "\"details\":" + objects, "{}");
  with("M4-65-levels-of-no-known-member", "A member of no table is 65 levels deep.",
       "\"other\":" + nested(64, '[', ']'), "[]");
  with("M4-50000-levels", "Arrays are 50,000 levels deep.", "\"other\":" + nested(50000, '[', ']'),
       "[]");
  with("M3-50000-arrays-not-closed", "50,000 arrays are opened and not closed.",
       "\"other\":" + std::string(50000, '['), "[[");

  const auto features = [&](const std::string& name, const std::string& fault,
                            const std::string& value) {
    add(name, fault, R"({"bodies":[{"name":"simplex"}],"features":)" + value + "}", value);
  };
  add("M5-no-features", "There are no features.", R"({"bodies":[{"name":"simplex"}]})");
  features("M5-null", "The features are null.", "null");
  features("M5-string", "The features are a string.", R"("zstd")");
  features("M5-object", "The features are an object.", R"({"zstd":true})");
  features("M5-number-in-it", "A feature is a number.", "[1]");
  features("M5-null-in-it", "A feature is null.", R"(["zstd",null])");
  features("M5-array-in-it", "A feature is an array.", R"([["zstd"]])");
  features("M6-unknown", "The file needs the feature wavelets.", R"(["zstd","wavelets"])");
  features("M6-upper-case", "The file needs the feature Zstd.", R"(["Zstd"])");
  features("M6-empty", "The file needs a feature without a name.", R"([""])");
  features("M6-space", "The file needs the feature \"zstd \".", R"(["zstd "])");
  features("M6-zero-character", "The file needs the feature zstd with a NUL behind it.",
           R"(["zstd\u0000"])");

  const auto bodies = [&](const std::string& name, const std::string& fault,
                          const std::string& value) {
    add(name, fault, R"({"features":[],"bodies":)" + value + "}", value);
  };
  add("M7-no-bodies", "There are no bodies.", R"({"features":[]})");
  add("M7-other-case", "The member is called Bodies.", R"({"features":[],"Bodies":["simplex"]})",
      "\"Bod");
  bodies("M7-empty", "No body is named.", "[]");
  cases.add(
      "M7-nothing", "No body is named, and none is counted.", base,
      [](Image& image) {
        image = Image(headJson({}, {}));
        image.addEnd();
      },
      "HEAD/json", headJson({}, {}).find("[]"));
  bodies("M7-string", "The bodies are a string.", R"("simplex")");
  bodies("M7-number", "The bodies are a number.", "1");
  bodies("M7-object", "The bodies are an object.", R"({"0":{"name":"simplex"}})");
  bodies("M7-string-in-it", "A body is a string, its name.", R"(["simplex"])");
  bodies("M7-null-in-it", "A body is null.", R"([null])");
  bodies("M7-array-in-it", "A body is an array.", R"([["name","simplex"]])");
  std::string many;
  for (int i = 0; i <= 65536; ++i) {
    many += fmt::format(R"({}{{"name":"{:x}"}})", i == 0 ? "" : ",", i);
  }
  bodies("M7-65537", "65,537 bodies are named.", "[" + many + "]");
  const auto named = [&](const std::string& name, const std::string& fault,
                         const std::string& value) {
    bodies(name, fault, R"([{"name":)" + value + "}]");
  };
  bodies("M8-no-name", "A body has no name.", "[{}]");
  named("M8-number", "A body's name is a number.", "1");
  named("M8-null", "A body's name is null.", "null");
  named("M8-empty", "A body's name has no bytes.", R"("")");
  named("M8-256-bytes", "A body's name has 256 bytes.", "\"" + std::string(256, 'n') + "\"");
  std::string euros;
  for (int i = 0; i < 86; ++i) euros += "\xE2\x82\xAC";
  named("M8-86-characters", "A body's name has 86 characters of three bytes.", "\"" + euros + "\"");
  for (const char* escape : {"0000", "000a", "001f", "007f", "0085", "009f", "002f", "061c", "200e",
                             "200f", "202a", "202e", "2066", "2069"}) {
    named(fmt::format("M8-u-{}", escape),
          fmt::format("A body's name has the character U+{}.", escape),
          fmt::format(R"("a\u{}b")", escape));
  }

  const auto member = [&](const std::string& name, const std::string& fault,
                          const std::string& value) {
    bodies(name, fault, R"([{"name":"simplex",)" + value + "}]");
  };
  member("M11-color-of-two", "A colour has two numbers.", R"("color":[0,1])");
  member("M11-color-of-five", "A colour has five numbers.", R"("color":[0,1,0,1,0])");
  member("M11-color-above-1", "A colour has the number 1.5.", R"("color":[0,1.5,0])");
  member("M11-color-below-0", "A colour has the number -0.5.", R"("color":[0,-0.5,0])");
  member("M11-color-of-strings", "A colour has strings.", R"("color":["0","1","0"])");
  member("M11-color-null", "A colour is null.", R"("color":null)");
  member("M11-material-number", "A material is a number.", R"("material":1)");
  member("M11-details-array", "The details of a body are an array.", R"("details":[])");
  member("M11-parent-number", "A parent is a number.", R"("parent":0)");
  member("M11-parent-empty", "A parent is an empty string.", R"("parent":"")");
  member("M11-parent-unknown", "A parent is no body of the file.", R"("parent":"other")");
  member("M11-parent-itself", "A body is a part of itself.", R"("parent":"simplex")");

  const Base two = baseOf({{"a", simplex()}, {"b", simplex()}});
  const auto twice = [&](const std::string& name, const std::string& fault,
                         const std::string& names) {
    const std::string json = R"({"features":[],"bodies":)" + names + "}";
    cases.add(
        name, fault, two,
        [&](Image& image) {
          image = Image::of({{"a", simplex()}, {"b", simplex()}}, {}, json);
        },
        "HEAD/json", json.find(',', json.find(names)));
  };
  twice("M9-twice", "Two bodies have one name.", R"([{"name":"a"},{"name":"a"}])");
  twice("M9-twice-by-escape", "Two bodies have one name, the second in escapes.",
        R"([{"name":"a"},{"name":"\u0061"}])");
  twice("M11-parents-of-each-other", "Two bodies are parts of each other.",
        R"([{"name":"a","parent":"b"},{"name":"b","parent":"a"}])");
  for (const char* member : {"generator", "backend", "length_unit", "time_unit"}) {
    with(fmt::format("M10-{}", member), fmt::format("{} is a number.", member),
         fmt::format("\"{}\":1", member));
  }
  with("M10-backend-null", "backend is null.", R"("backend":null)");
  with("M10-length-unit-array", "length_unit is an array.", R"("length_unit":["mm"])");
  with("M10-up-x", "up is x.", R"("up":"x")");
  with("M10-up-upper-case", "up is Y.", R"("up":"Y")");
  with("M10-up-empty", "up is an empty string.", R"("up":"")");
  with("M10-up-number", "up is a number.", R"("up":1)");
  for (const auto& [name, value] : {
           std::pair<const char*, const char*>{"array", "[0,0,0,1]"},
           {"number", "1"},
           {"null", "null"},
           {"empty", "{}"},
           {"without-step", R"({"origin":[0,0,0]})"},
           {"without-origin", R"({"step":1})"},
           {"origin-of-two", R"({"origin":[0,0],"step":1})"},
           {"origin-of-text", R"({"origin":[0,0,"0"],"step":1})"},
           {"step-0", R"({"origin":[0,0,0],"step":0})"},
           {"step-negative", R"({"origin":[0,0,0],"step":-1})"},
           {"step-text", R"({"origin":[0,0,0],"step":"1"})"},
           {"step-true", R"({"origin":[0,0,0],"step":true})"},
       }) {
    with(fmt::format("M10-grid-{}", name), "grid is not as it must be.",
         fmt::format(R"("grid":{})", value));
  }
  add("M10-grid-missing", "The feature grid is named, and there is none.",
      R"({"features":["grid"],"bodies":[{"name":"simplex"}]})", R"(["grid"])");
  with("M10-details-array", "details is an array.", R"("details":[])");
  with("M10-details-string", "details is a string.", R"("details":"none")");
  with("M10-details-null", "details is null.", R"("details":null)");
}

}  // namespace t4d::conformance
