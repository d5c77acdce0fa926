#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/gltf_geometry.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Colours and texture coordinates of the points of a GltfGeometry.
struct GltfLooks {
  /// `color` and `uv` as of Keep::Attributes, with a row for each point of all parts.
  std::vector<model::Attribute> rows;
  std::set<std::string> names;       ///< of these attributes in glTF: COLOR_0, TEXCOORD_0
  std::vector<std::string> notices;  ///< what was filled in where a primitive has none
};

/// Reads COLOR_0 and TEXCOORD_0 of the parts, those that at least one has. One with accessors that
/// glTF does not allow is left out.
GltfLooks readGltfLooks(const InputFile& file, const tinygltf::Model& model,
                        std::span<const GltfGeometry::Part> parts);

}  // namespace t4d::formats
