#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace t4d::conformance {

/// What a stranger's program has printed, fit for one line of a terminal, JSON and XML: UTF-8
/// without control characters; other bytes as \x1b, ends of lines as \n. Of more than `most` bytes
/// the rest is "...".
std::string plain(std::string_view text, std::size_t most = std::string_view::npos);

}  // namespace t4d::conformance
