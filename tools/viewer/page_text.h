#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace t4d::tools {

/// The page of web/viewer, in parts one after another.
extern const std::string_view kPageText[];
extern const std::size_t kPageTextParts;

/// The page, as ViewOptions::viewer.
inline std::string pageText() {
  std::string text;
  for (std::size_t i = 0; i < kPageTextParts; ++i) text += kPageText[i];
  return text;
}

}  // namespace t4d::tools
