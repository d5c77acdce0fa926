#pragma once

#include <string>

#include "t4d/error.h"

namespace t4d::tools {

/// The bytes of a PNG file that shows an SVG file, with `pixelsPerUnit` pixels for each unit of its
/// viewBox. Fails if librsvg cannot draw it; without librsvg always.
Result<std::string> pngOfSvg(const std::string& svg, double pixelsPerUnit);

}  // namespace t4d::tools
