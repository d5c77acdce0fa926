#include "formats/motion/srdf_reader.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>

#include <expat.h>
#include <fmt/format.h>

#include "formats/input_file.h"
#include "platform/xml_position.h"

namespace t4d::formats {
namespace {

class SrdfParser {
 public:
  explicit SrdfParser(const InputFile& file) : file_(file) {}

  Result<DisabledCollisions> parse() {
    constexpr std::size_t kMostBytes = std::size_t{1} << 26;
    if (file_.bytes.size() > kMostBytes) {
      return fail(ErrorCode::Unsupported, "is larger than any SRDF file: 64 MiB",
                  file_.path.string());
    }
    const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                         XML_ParserFree);
    parser_ = parser.get();
    XML_SetUserData(parser_, this);
    XML_SetStartElementHandler(parser_, onStart);
    const auto status =
        XML_Parse(parser_, file_.bytes.data(), static_cast<int>(file_.bytes.size()), 1);
    if (problem_) return *problem_;
    if (status != XML_STATUS_OK) {
      return invalid(fmt::format("is not XML: {}", XML_ErrorString(XML_GetErrorCode(parser_))),
                     file_.atLine(platform::xmlLine(parser_)));
    }
    return std::move(found_);
  }

 private:
  static void onStart(void* self, const char* name, const char** attributes) {
    static_cast<SrdfParser*>(self)->start(name, attributes);
  }

  void start(std::string_view name, const char** attributes) {
    if (!inRobot_ && name != "robot") {
      stop(fmt::format("begins with <{}>, expected <robot>, as in an SRDF file", name));
      return;
    }
    inRobot_ = true;
    if (name == "disable_default_collisions") {
      if (std::string link = attribute(attributes, "link"); !link.empty()) {
        found_.links.insert(std::move(link));
      } else {
        stop("<disable_default_collisions> has no link");
      }
    }
    if (name != "disable_collisions" && name != "enable_collisions") return;
    DisabledCollisions::Pair links = {attribute(attributes, "link1"),
                                      attribute(attributes, "link2")};
    if (links[0].empty() || links[1].empty()) {
      stop(fmt::format("<{}> has no link1 or no link2", name));
    } else if (name == "disable_collisions") {
      found_.pairs.push_back(std::move(links));
    } else {
      found_.enabled.insert({links[1], links[0]});
      found_.enabled.insert(std::move(links));
    }
  }

  static std::string attribute(const char** attributes, std::string_view wanted) {
    for (; *attributes != nullptr; attributes += 2) {
      if (attributes[0] == wanted) return attributes[1];
    }
    return {};
  }

  void stop(std::string message) {
    problem_ = Error{ErrorCode::InvalidInput, std::move(message),
                     file_.atLine(platform::xmlLine(parser_))};
    XML_StopParser(parser_, XML_FALSE);
  }

  const InputFile& file_;
  XML_Parser parser_ = nullptr;
  bool inRobot_ = false;
  DisabledCollisions found_;
  std::optional<Error> problem_;
};

}  // namespace

bool DisabledCollisions::contains(const std::string& a, const std::string& b) const {
  const bool listed = std::ranges::any_of(pairs, [&](const Pair& pair) {
    return pair == Pair{a, b} || pair == Pair{b, a};
  });
  return listed || ((links.contains(a) || links.contains(b)) && !enabled.contains({a, b}));
}

std::set<std::string> DisabledCollisions::names() const {
  std::set<std::string> names = links;
  for (const Pair& pair : pairs) names.insert(pair.begin(), pair.end());
  for (const Pair& pair : enabled) names.insert(pair.begin(), pair.end());
  return names;
}

Result<DisabledCollisions> readDisabledCollisions(const std::filesystem::path& path) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  return SrdfParser(*file).parse();
}

}  // namespace t4d::formats
