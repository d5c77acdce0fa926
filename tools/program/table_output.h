#pragma once

#include <string>

#include "t4d/model/error.h"

namespace t4d::tools {

/// True for the name of a table (.csv, .json) or of a plot (.svg, .png).
bool isTableOrPlot(const std::string& path);

/// A plot (svg_plot.h) as the bytes of a file: a PNG if the name says so, otherwise an SVG.
Result<std::string> plotFile(const std::string& path, std::string svg);

}  // namespace t4d::tools
