#pragma once

#include <string_view>

namespace t4d::model {

/// The end of the name of an attribute of triangles, or of the cells that a triangle sweeps, that
/// has what an attribute of vertices has at the three corners of the triangle, one after the other:
/// "color:corners" has three times the components of "color". Cells share it in all steps of a
/// sweep, as they share their connectivity, which vertices of layers cannot.
inline constexpr std::string_view kCornersOf = ":corners";

}  // namespace t4d::model
