#include "tools/report/html_page.h"

#include <fmt/format.h>

#include "formats/text/base64.h"

namespace t4d::tools {
namespace {

/// The first value of each colour is for light screens.
constexpr std::string_view kPageStyle = R"(
:root { color-scheme: light dark; --ink: #1c2330; --soft: #5d6778; --line: #dfe3ea;
  --page: #ffffff; --card: #f6f7f9; --a: #2a6cb8; --b: #c9651a; --d: #6d4fb3; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8ebf0; --soft: #9aa5b5; --line: #333b48;
  --page: #14181f; --card: #1c222b; --a: #6aa9ee; --b: #f0985a; --d: #b59cf0; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1360px; padding: 32px 24px 64px; background: var(--page);
  color: var(--ink); font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 18px; margin: 40px 0 12px; }
p { margin: 0 0 12px; color: var(--soft); max-width: 75ch; }
.scroll { overflow-x: auto; margin-bottom: 12px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 5px 16px 5px 0; text-align: right; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th { font-weight: 600; color: var(--soft); white-space: normal; vertical-align: bottom; }
td:first-child, th:first-child { text-align: left; }
details { margin: 0 0 6px; }
summary { cursor: pointer; }
details th:last-child, details td:last-child { text-align: left; }
.key { font-weight: 600; }
.key.a { color: var(--a); } .key.b { color: var(--b); } .key.d { color: var(--d); }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(520px, 100%), 1fr)); gap: 16px;
  margin: 0 0 16px; }
.plots svg { width: 100%; background: var(--card); border-radius: 8px; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(300px, 100%), 1fr)); gap: 16px;
  margin: 0 0 16px; }
figure { margin: 0; background: var(--card); border-radius: 8px; padding: 10px 12px 12px; }
figure img { width: 100%; height: auto; display: block; }
figcaption { font-size: 13px; color: var(--soft); }
)";

constexpr std::string_view kPlotStyle = R"(svg text { font-size: 12px; fill: var(--soft); }
svg .title { font-size: 14px; font-weight: 600; fill: var(--ink); }
svg .grid { stroke: var(--line); }
.curve { fill: none; stroke-width: 2; }
.curve.a { stroke: var(--a); } .curve.b { stroke: var(--b); } .curve.d { stroke: var(--d); }
.curve.dashed { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.dot.dashed { fill: none; }
.dot.a { fill: var(--a); } .dot.b { fill: var(--b); } .dot.d { fill: var(--d); }
)";

/// The style with light colours in place of their names, which not every program knows.
std::string inLightColours(std::string style) {
  constexpr std::string_view kBegin = "var(--";
  for (std::size_t at; (at = style.find(kBegin)) != std::string::npos;) {
    const std::size_t end = style.find(')', at);
    const std::string name = style.substr(at + kBegin.size(), end - at - kBegin.size());
    const std::size_t value = kPageStyle.find("--" + name + ": ") + name.size() + 4;
    style.replace(at, end + 1 - at,
                  kPageStyle.substr(value, kPageStyle.find_first_of("; ", value) - value));
  }
  return style;
}

}  // namespace

std::string htmlPage(const std::string& title, const std::string& bodyHtml) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n"
      "<style>{1}{2}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{3}</body>\n</html>\n",
      escaped(title), kPageStyle, kPlotStyle, bodyHtml);
}

std::string headingOf(const std::string& text) {
  return fmt::format("<h2>{}</h2>\n", escaped(text));
}

std::string paragraphOf(const std::string& text) {
  return fmt::format("<p>{}</p>\n", escaped(text));
}

std::string svgFile(std::string svg) {
  svg.insert(svg.find(' '), " xmlns=\"http://www.w3.org/2000/svg\"");
  svg.insert(svg.find('>') + 1,
             fmt::format("\n<style>{}svg {{ font-family: sans-serif; }}</style>\n"
                         "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>",
                         inLightColours(std::string(kPlotStyle))));
  return svg;
}

std::string figureOf(std::span<const std::uint8_t> png, std::uint32_t pixels,
                     const std::string& caption) {
  return fmt::format(
      "<figure><img alt=\"{0}\" width=\"{1}\" height=\"{1}\" src=\"data:image/png;base64,{2}\">"
      "<figcaption>{0}</figcaption></figure>\n",
      escaped(caption), pixels, formats::base64(png));
}

std::string figuresOf(const std::string& figuresHtml) {
  return "<div class=\"figures\">\n" + figuresHtml + "</div>\n";
}

std::string tableOf(const Table& rows) {
  std::string html = "<div class=\"scroll\"><table>\n";
  for (const std::vector<std::string>& row : rows) {
    const char* tag = &row == &rows.front() ? "th" : "td";
    html += "<tr>";
    for (const std::string& cell : row) html += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string labelled(const std::string& text, const std::string& unit, std::string_view power) {
  return unit.empty() ? text : fmt::format("{} [{}{}]", text, unit, power);
}

std::string withUnit(double number, const std::string& unit, std::string_view power) {
  return unit.empty() ? fmt::format("{:.6g}", number)
                      : fmt::format("{:.6g} {}{}", number, unit, power);
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    const std::string_view name = c == '&'   ? "amp"
                                  : c == '<' ? "lt"
                                  : c == '>' ? "gt"
                                  : c == '"' ? "quot"
                                             : "";
    safe += name.empty() ? std::string(1, c) : fmt::format("&{};", name);
  }
  return safe;
}

}  // namespace t4d::tools
