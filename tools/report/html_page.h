#pragma once

#include <string>
#include <string_view>

namespace t4d::tools {

/// An HTML page that loads nothing: a heading, then `body`. Tables, `.plots` of <svg>, `.curve`,
/// `.dot` and `.key` with the classes `a`, `b` and `d` have their style, for light and dark
/// screens; `style` adds to it.
std::string htmlPage(const std::string& title, std::string_view style, const std::string& body);

/// The text with what HTML gives a meaning to replaced.
std::string escaped(const std::string& text);

}  // namespace t4d::tools
