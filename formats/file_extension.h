#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>

#include "platform/file_format.h"

namespace t4d::formats {

/// The extension with its dot, in lower case; empty when there is none.
inline std::string lowerCaseExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

/// Whether a file is of one of these formats by its extension.
inline bool isOneOf(std::span<const platform::FileFormat> formats,
                    const std::filesystem::path& path) {
  const std::string extension = lowerCaseExtension(path);
  return std::ranges::any_of(formats, [&](const platform::FileFormat& format) {
    return std::ranges::find(format.extensions, extension) != format.extensions.end();
  });
}

}  // namespace t4d::formats
