#include "tools/recovery_hint.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "formats/t4d/layout.h"

namespace t4d::tools {
namespace {

using namespace formats::t4d_layout;

/// The signature, or what follows a damaged file header.
bool beginsAsT4d(const std::string& path) {
  std::array<char, kFileHeaderBytes + sizeof(ChunkType)> begin{};
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), begin.size());
  return std::memcmp(begin.data(), kSignature.data(), kSignature.size()) == 0 ||
         std::memcmp(begin.data() + kFileHeaderBytes, kHead.data(), kHead.size()) == 0;
}

/// As one word for a shell.
std::string quoted(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c >= 0x80 || std::strchr("/._-+,:@%=", c) != nullptr;
  };
  if (!word.empty() && word[0] != '-' && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::string recoveryCommand(const std::string& path) {
  if (!beginsAsT4d(path)) return {};
  std::string name = std::filesystem::path(path).stem().string();
  // A part file that was left behind is hidden.
  name.erase(0, name.find_first_not_of('.'));
  return fmt::format("t4d recover {} -o {}", quoted(path), quoted(name + "-recovered.t4d"));
}

std::string recoveryCommand(const Error& error) {
  if (error.code != ErrorCode::InvalidInput || !error.offset) return {};
  const std::string place = fmt::format(": byte {}", *error.offset);
  if (!error.where.ends_with(place)) return {};
  return recoveryCommand(error.where.substr(0, error.where.size() - place.size()));
}

}  // namespace t4d::tools
