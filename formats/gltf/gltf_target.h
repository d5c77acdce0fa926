#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace t4d::formats {

/// The property that a channel of an animation moves.
struct GltfTarget {
  enum class Property : std::uint8_t { Translation, Rotation, Scale, Weights, Visible, Other };

  Property property = Property::Other;
  std::vector<int> nodes;  ///< all that it moves; their numbers are not checked
  /// The name for messages: `translation`, or a pointer such as `/nodes/1/translation`.
  std::string name;
};

/// A channel may name a node and a path, or, with KHR_animation_pointer, any property of the
/// document. Pointers to translation, rotation, scale and weights of nodes are what paths are, and
/// pointers to weights of meshes move all nodes that have no weights of their own;
/// KHR_node_visibility is Visible. Everything else is Other.
GltfTarget gltfTargetOf(const tinygltf::Model& model, const tinygltf::AnimationChannel& channel);

}  // namespace t4d::formats
