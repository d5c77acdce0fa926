#include "tools/t4d/body_files.h"

#include <fmt/format.h>

#include "platform/replaceable.h"

namespace t4d::tools {
namespace {

constexpr std::string_view kBodyPlace = "{body}";

std::string bodyFileName(const std::string& pattern, const std::string& body) {
  std::string name = pattern;
  for (auto at = name.find(kBodyPlace); at != name.npos;
       at = name.find(kBodyPlace, at + body.size())) {
    name.replace(at, kBodyPlace.size(), body);
  }
  return name;
}

}  // namespace

bool isPerBody(const std::string& output) { return output.find(kBodyPlace) != output.npos; }

std::optional<std::string> misuseOfPerBody(const std::string& output) {
  if (!isPerBody(std::filesystem::path(output).parent_path().string())) return std::nullopt;
  return fmt::format("'{}': {} must be in the name of the file, not in that of a folder", output,
                     kBodyPlace);
}

Result<std::vector<std::filesystem::path>> bodyFiles(const std::string& output,
                                                     std::span<const std::string> bodies) {
  const std::filesystem::path path(output);
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;
  for (const std::string& body : bodies) {
    names.push_back(bodyFileName(path.filename().string(), body));
    files.push_back(path.parent_path() / names.back());
  }
  if (auto good = platform::checkReplaceable(path.parent_path(), names); !good) {
    return good.error();
  }
  return files;
}

}  // namespace t4d::tools
