#pragma once

#include <string>
#include <vector>

#include "formats/mesh4d/flat_bodies.h"
#include "t4d/mesh.h"

/// Data about the bodies that both writers of Gmsh state.
namespace t4d::formats {

/// A name between quotes on one line.
std::string gmshName(std::string name);

/// The bounds of each body in space, which Gmsh's entities state.
Result<std::vector<model::Bounds3>> gmshBounds(const FlatBodies& mesh);

}  // namespace t4d::formats
