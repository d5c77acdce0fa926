#pragma once

#include <filesystem>
#include <string>

namespace t4d::formats {

/// The extension with its dot, in lower case; empty when there is none.
inline std::string lowerCaseExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

}  // namespace t4d::formats
