#pragma once

#include <cstddef>
#include <string_view>

namespace t4d::tools {

/// The page of web/viewer, in parts one after another.
extern const std::string_view kPageText[];
extern const std::size_t kPageTextParts;

}  // namespace t4d::tools
