#pragma once

#include <string>

#include <fmt/format.h>

namespace t4d::tools {

/// A phrase about the detail of slices, for reports. `distance` is that of slice::LightSlice.
inline std::string detailText(bool light, double distance) {
  if (!light && distance == 0) return "exact slices";
  const std::string within = distance == 0
                                 ? std::string("equal to the exact slices")
                                 : fmt::format("within {:.3g} of the exact slices", distance);
  return light ? "light: the layers' triangles, " + within
               : "light where slabs consist of prisms, " + within;
}

}  // namespace t4d::tools
