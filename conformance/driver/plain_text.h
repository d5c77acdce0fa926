#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace t4d::conformance {

/// Escapes the output of another program for one line of a terminal, JSON or XML: UTF-8 without
/// control characters; other bytes become \x1b, line feeds \n. Text beyond `most` bytes becomes
/// "...".
std::string plain(std::string_view text, std::size_t most = std::string_view::npos);

}  // namespace t4d::conformance
