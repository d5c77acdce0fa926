#include "tools/program/recovery_hint.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "t4d/formats/t4d/salvage.h"

namespace t4d::tools {
namespace {

/// Of the file are looked at, so that the hint does not keep anyone waiting.
constexpr std::uint64_t kLooked = std::uint64_t{256} << 20;

/// A path as one word for a shell, and no option.
std::string quoted(std::string word) {
  if (word.starts_with('-')) word.insert(0, "./");
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c >= 0x80 || std::strchr("/._-+,:@%=", c) != nullptr;
  };
  if (std::all_of(word.begin(), word.end(), plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::string recoveryCommand(const std::string& path) {
  namespace fs = std::filesystem;
  if (!formats::T4dSalvage::finds(path, kLooked)) return {};
  std::string name = fs::path(path).stem().string();
  // A part file that was left behind is hidden.
  name.erase(0, name.find_first_not_of('.'));
  const std::string output = (fs::path(path).parent_path() / (name + "-recovered")).string();
  std::string free = output + ".t4d";
  std::error_code ignored;
  for (int i = 2; fs::exists(free, ignored); ++i) free = fmt::format("{}-{}.t4d", output, i);
  return fmt::format("t4d recover {} -o {}", quoted(path), quoted(free));
}

std::string recoveryCommand(const Error& error) {
  if (error.code != ErrorCode::InvalidInput || !error.offset) return {};
  const std::string place = fmt::format(": byte {}", *error.offset);
  if (!error.where.ends_with(place)) return {};
  return recoveryCommand(error.where.substr(0, error.where.size() - place.size()));
}

}  // namespace t4d::tools
