#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Pieces of a self-contained HTML page, for light and dark screens. Texts are escaped, except
/// those whose name ends in Html.
namespace t4d::tools {

/// The whole page: a heading, then `bodyHtml`.
std::string htmlPage(const std::string& title, const std::string& bodyHtml);

/// The heading of a section.
std::string headingOf(const std::string& text);

std::string paragraphOf(const std::string& text);

/// Rows of cells; the first is the heading, and may be empty.
using Table = std::vector<std::vector<std::string>>;
std::string tableOf(const Table& rows);

/// A square picture, the bytes of a PNG file, with its caption below.
std::string figureOf(std::span<const std::uint8_t> png, std::uint32_t pixels,
                     const std::string& caption);

/// Figures side by side.
std::string figuresOf(const std::string& figuresHtml);

/// An <svg> element (svg_plot.h) as a file of its own, in the style of light screens on white.
std::string svgFile(std::string svg);

/// A title or label with its unit: "Volume [mm³]"; the text alone where the unit is not known.
std::string labelled(const std::string& text, const std::string& unit, std::string_view power = {});

/// A number with its unit: "12.5 mm³"; the number alone where the unit is not known.
std::string withUnit(double number, const std::string& unit, std::string_view power = {});

/// The text with HTML's special characters escaped.
std::string escaped(const std::string& text);

}  // namespace t4d::tools
