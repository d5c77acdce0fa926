#pragma once

#include <span>
#include <string>

#include "t4d/surface.h"

namespace t4d::formats {

/// Puts the vertices of a mesh where the points of its file are. Fails if points that are one
/// vertex have come apart.
Result<void> placeVertices(const FilePoints& file, std::span<const model::Point3> points,
                           std::span<model::Point3> vertices, const std::string& where);

}  // namespace t4d::formats
