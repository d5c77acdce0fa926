#pragma once

#include "mill/tool_shape.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::conformance {

/// A field as the rest of a stock after milling.
struct Milling {
  model::TriangleMesh stock;
  mill::ToolShape tool;
  model::Point3 start;   ///< of the tip
  model::Motion motion;  ///< of the tool, from its position at the start
};

}  // namespace t4d::conformance
