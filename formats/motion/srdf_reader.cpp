#include "formats/motion/srdf_reader.h"

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

  Result<std::vector<std::array<std::string, 2>>> parse() {
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
    return std::move(pairs_);
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
    if (name != "disable_collisions") return;
    std::array<std::string, 2> links;
    for (; *attributes != nullptr; attributes += 2) {
      const std::string_view key = attributes[0];
      if (key == "link1") links[0] = attributes[1];
      if (key == "link2") links[1] = attributes[1];
    }
    if (links[0].empty() || links[1].empty()) {
      stop("<disable_collisions> has no link1 or no link2");
      return;
    }
    pairs_.push_back(std::move(links));
  }

  void stop(std::string message) {
    problem_ = Error{ErrorCode::InvalidInput, std::move(message),
                     file_.atLine(platform::xmlLine(parser_))};
    XML_StopParser(parser_, XML_FALSE);
  }

  const InputFile& file_;
  XML_Parser parser_ = nullptr;
  bool inRobot_ = false;
  std::vector<std::array<std::string, 2>> pairs_;
  std::optional<Error> problem_;
};

}  // namespace

Result<std::vector<std::array<std::string, 2>>> readDisabledCollisions(
    const std::filesystem::path& path) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  return SrdfParser(*file).parse();
}

}  // namespace t4d::formats
