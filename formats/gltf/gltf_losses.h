#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace t4d::formats {

/// The parts of a document that the reader uses.
struct GltfUse {
  std::set<int> nodes;            ///< of the scene, with a mesh at or below them; hidden ones, too
  std::set<int> meshes;           ///< of these nodes; without nodes, all of them
  bool animated = false;          ///< with skins and morph targets; otherwise at rest
  std::optional<int> scene = {};  ///< nothing for the default one
  std::set<std::string> attributes = {};  ///< of vertices, besides positions: COLOR_0, ...
  bool materialNames = false;             ///< the names of materials, but nothing else of them
};

/// A sentence for each thing that a glTF document holds and a triangle mesh does not: geometry
/// first (animation, skins, morph targets, ...), then one for all that only concerns its look. Only
/// what concerns a used node or mesh is named, and meshes and scenes that are left out.
std::vector<std::string> gltfLosses(const tinygltf::Model& model, const GltfUse& used);

}  // namespace t4d::formats
