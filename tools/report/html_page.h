#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace t4d::tools {

/// A self-contained HTML page: a heading, then `body`. Tables, figures, `.plots` of <svg>, and
/// `.curve`, `.dot` and `.key` with the classes `a`, `b` and `d` are styled, for light and dark
/// screens; `style` is added to that.
std::string htmlPage(const std::string& title, std::string_view style, const std::string& body);

/// An <svg> element as a file of its own, in the style of light screens on white.
std::string svgFile(std::string svg);

/// A square picture, the bytes of a PNG file, with its caption below.
std::string figureOf(std::span<const std::uint8_t> png, std::uint32_t pixels,
                     const std::string& caption);

/// A table; the first row is the heading.
std::string tableOf(const std::vector<std::vector<std::string>>& rows,
                    std::string_view cssClass = {});

/// The text with HTML's special characters escaped.
std::string escaped(const std::string& text);

}  // namespace t4d::tools
