#include "tools/t4d/table_output.h"

#include <algorithm>
#include <string_view>

#include "formats/file_extension.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_picture.h"

namespace t4d::tools {

bool isTableOrPlot(const std::string& path) {
  return std::ranges::find(kTablesAndPlots, formats::lowerCaseExtension(path)) !=
         kTablesAndPlots.end();
}

Result<std::string> plotFile(const std::string& path, std::string svg) {
  constexpr double kPixelsPerUnit = 2;
  std::string file = svgFile(std::move(svg));
  if (formats::lowerCaseExtension(path) != ".png") return file;
  return pngOfSvg(file, kPixelsPerUnit);
}

}  // namespace t4d::tools
