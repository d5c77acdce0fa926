#include "tools/report/svg_picture.h"

namespace t4d::tools {

Result<std::string> pngOfSvg(const std::string& /*svg*/, double /*pixelsPerUnit*/) {
  return fail(ErrorCode::Unsupported,
              "this build has no librsvg, which draws .png files; .svg files need none");
}

}  // namespace t4d::tools
