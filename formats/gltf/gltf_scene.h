#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "formats/gltf/gltf_model.h"

namespace t4d::formats {

struct GltfNode {
  int index = 0;
  int parent = -1;        ///< the index of another node; -1 for none
  Eigen::Affine3d local;  ///< at rest, from its coordinates to those of its parent
  bool visible = true;    ///< at rest, by itself (KHR_node_visibility)
};

struct GltfScene {
  std::vector<GltfNode> nodes;  ///< parents before their children
  bool sheared = false;         ///< whether a matrix shears, which glTF does not allow
};

/// The nodes of a scene: the default one, or without scenes all nodes. Fails on nodes that do not
/// exist, with two parents, or with a transform that glTF does not allow.
Result<GltfScene> readGltfScene(const InputFile& file, const tinygltf::Model& model,
                                std::optional<int> scene = {});

}  // namespace t4d::formats
