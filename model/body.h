#pragma once

#include <span>
#include <string>

#include "model/slab.h"

namespace t4d::model {

/// A named 4D mesh; a file may have several.
struct Body {
  std::string name = {};
  const Source* source = nullptr;
};

/// From the first time of any body to the last; {0, 0} if no body has a slab.
TimeSpan timeSpanOf(std::span<const Body> bodies);

}  // namespace t4d::model
