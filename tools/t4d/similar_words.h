#pragma once

#include <span>
#include <string>
#include <string_view>

namespace t4d::tools {

/// " (did you mean X?)" for the most similar of `words`, if it is only a typing error away; ""
/// otherwise.
std::string didYouMean(std::string_view word, std::span<const std::string> words);

}  // namespace t4d::tools
