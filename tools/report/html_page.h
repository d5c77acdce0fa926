#pragma once

#include <string>
#include <string_view>

namespace t4d::tools {

/// A self-contained HTML page: a heading, then `body`. Tables, `.plots` of <svg>, and `.curve`,
/// `.dot` and `.key` with the classes `a`, `b` and `d` are styled, for light and dark screens;
/// `style` is added to that.
std::string htmlPage(const std::string& title, std::string_view style, const std::string& body);

/// The text with HTML's special characters escaped.
std::string escaped(const std::string& text);

}  // namespace t4d::tools
