#include "formats/motion/package_path.h"

#include <cstdlib>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "formats/input_file.h"

namespace t4d::formats {
namespace {

namespace fs = std::filesystem;

/// The text of the first <name>, which is that of the package.
std::string nameInXml(std::string_view text) {
  constexpr std::string_view kOpen = "<name>";
  const auto open = text.find(kOpen);
  if (open == text.npos) return {};
  text.remove_prefix(open + kOpen.size());
  std::istringstream words{std::string(text.substr(0, text.find('<')))};
  std::string name;
  words >> name;
  return name;
}

bool isPackage(const fs::path& folder, const std::string& name) {
  if (folder.filename() == name) return true;
  const auto description = readInputFile(folder / "package.xml");
  return description && nameInXml(description->bytes) == name;
}

/// The folders that a variable of the environment lists.
std::vector<fs::path> foldersOf(const char* variable) {
  const char* text = std::getenv(variable);
  std::istringstream list(text == nullptr ? "" : text);
  std::vector<fs::path> folders;
  for (std::string one; std::getline(list, one, ':');) {
    if (!one.empty()) folders.emplace_back(one);
  }
  return folders;
}

std::vector<fs::path> placesOfPackages(const fs::path& home) {
  std::error_code error;
  std::vector<fs::path> places;
  for (auto at = fs::absolute(home, error).lexically_normal();; at = at.parent_path()) {
    places.push_back(at);
    if (at == at.parent_path()) break;
  }
  for (fs::path& folder : foldersOf("ROS_PACKAGE_PATH")) places.push_back(std::move(folder));
  for (const fs::path& prefix : foldersOf("AMENT_PREFIX_PATH")) places.push_back(prefix / "share");
  return places;
}

}  // namespace

std::optional<fs::path> packageFile(const std::string& rest, const fs::path& home,
                                    const Packages& packages) {
  const auto isFile = [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
  };
  const auto slash = rest.find('/');
  const std::string name = rest.substr(0, slash);
  const std::string within =
      slash == rest.npos ? "" : rest.substr(rest.find_first_not_of('/', slash));
  if (const auto known = packages.find(name); known != packages.end()) {
    const fs::path path = known->second / within;
    return isFile(path) ? std::optional(path) : std::nullopt;
  }
  for (const fs::path& folder : placesOfPackages(home)) {
    if (const fs::path path = folder / name / within; isFile(path)) return path;
    if (const fs::path path = folder / within; isFile(path) && isPackage(folder, name)) return path;
  }
  return std::nullopt;
}

}  // namespace t4d::formats
