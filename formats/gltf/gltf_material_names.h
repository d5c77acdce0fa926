#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "formats/gltf/gltf_geometry.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Numbers the materials of glTF files, as the attribute `material` does (Keep::Attributes).
class GltfMaterialNames {
 public:
  /// The model must outlive this object.
  explicit GltfMaterialNames(const tinygltf::Model& model) : model_(model) {}

  /// Adds the attribute `material` to a mesh if one of its parts has a material: `partOf` is the
  /// part of each triangle.
  void addTo(model::TriangleMesh& mesh, std::span<const GltfGeometry::Part> parts,
             std::span<const std::uint32_t> partOf);

  /// The names by number, as in LoadedMesh::materials: the first is "". Empty if no mesh has a
  /// material.
  std::vector<std::string> names() const;

 private:
  /// 0 for none, and for the material that the writer gives to meshes without any.
  std::uint32_t numberOf(int material);

  const tinygltf::Model& model_;
  std::vector<std::string> names_ = {""};
  std::map<int, std::uint32_t> numbers_;
};

}  // namespace t4d::formats
