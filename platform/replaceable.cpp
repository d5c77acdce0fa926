#include "platform/replaceable.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

/// What our writers put into their files: comments, the generator of glTF, .t4d and manifests, the
/// creator of OpenVDB grids.
constexpr std::array<std::string_view, 4> kMarks = {
    "written by t4d", R"("generator":"t4d)", R"("generator": "t4d)",
    std::string_view("creator\x06\0\0\0string\x03\0\0\0t4d", 24)};
constexpr std::size_t kLongestMark = 32;

constexpr std::size_t kMarkWithin = 1 << 16;

}  // namespace

bool isOwnFile(const fs::path& path) {
  // glTF names its generator after its arrays.
  const bool anywhere = path.extension() == ".glb" || path.extension() == ".gltf";
  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  do {
    // A mark may lie across two pieces.
    bytes.erase(0, bytes.size() - std::min(bytes.size(), kLongestMark));
    const std::size_t kept = bytes.size();
    bytes.resize(kept + kMarkWithin);
    in.read(bytes.data() + kept, static_cast<std::streamsize>(kMarkWithin));
    bytes.resize(kept + static_cast<std::size_t>(in.gcount()));
    if (std::ranges::any_of(kMarks, [&](auto mark) { return bytes.find(mark) != bytes.npos; })) {
      return true;
    }
  } while (in && anywhere);
  return false;
}

Result<void> checkReplaceable(const fs::path& folder, std::span<const std::string> names,
                              const std::function<bool(const fs::path&)>& mayReplace) {
  const auto refuse = [&](const fs::path& name, const char* why) {
    return fail(ErrorCode::Failed, fmt::format("{}; move it or name another output", why),
                (folder / name).string());
  };
  std::error_code ignored;
  for (const std::string& name : names) {
    fs::path within;
    for (const fs::path& part : fs::path(name)) {
      within /= part;
      if (fs::is_symlink(folder / within, ignored)) {
        return refuse(within, "is a symbolic link, which is neither followed nor replaced");
      }
    }
    const fs::path path = folder / name;
    const fs::file_status there = fs::symlink_status(path, ignored);
    if (fs::exists(there) && !(fs::is_regular_file(there) && mayReplace(path))) {
      return refuse(name, "exists and was not written by t4d");
    }
  }
  return {};
}

}  // namespace t4d::platform
