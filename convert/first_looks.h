#pragma once

#include <string>
#include <vector>

#include "t4d/convert.h"

namespace t4d::convert {

/// Gives the mesh of a body that moves or morphs during `span` the attributes of its light slice at
/// the first of these times, and paints it by them. There are none where the slice has other
/// triangles. Of attributes that are to be written, those whose values are vectors, points or
/// normals are left out, since they would not move with the mesh. Returns a line for each that is
/// lost, and for each whose values are others at the end of the span.
Result<std::vector<std::string>> addFirstLooks(const model::Body& body, const model::TimeSpan& span,
                                               const FlipbookOptions& options,
                                               formats::NamedMesh& mesh);

}  // namespace t4d::convert
