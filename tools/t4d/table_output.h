#pragma once

#include <array>
#include <string>
#include <string_view>

#include "t4d/error.h"

namespace t4d::tools {

/// The extensions of tables and of plots.
inline constexpr std::array<std::string_view, 4> kTablesAndPlots = {".csv", ".json", ".svg",
                                                                    ".png"};

/// True for the name of a table or of a plot.
bool isTableOrPlot(const std::string& path);

/// A plot (svg_plot.h) as the bytes of a file: a PNG if the name says so, otherwise an SVG.
Result<std::string> plotFile(const std::string& path, std::string svg);

}  // namespace t4d::tools
