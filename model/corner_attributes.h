#pragma once

#include <string_view>

namespace t4d::model {

/// The suffix of the names of corner attributes. A corner attribute belongs to triangles, or to the
/// cells that a triangle sweeps, and has the values of a vertex attribute at the three corners of
/// the triangle, in order: "color:corners" has three times the components of "color". All steps of
/// a sweep share corner attributes, since they share their connectivity; attributes of layer
/// vertices could not be shared.
inline constexpr std::string_view kCornersOf = ":corners";

}  // namespace t4d::model
