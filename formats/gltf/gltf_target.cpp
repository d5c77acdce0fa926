#include "formats/gltf/gltf_target.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "model/number.h"

namespace t4d::formats {
namespace {

using Property = GltfTarget::Property;

constexpr std::array<std::pair<std::string_view, Property>, 4> kPaths = {
    std::pair{"translation", Property::Translation},
    {"rotation", Property::Rotation},
    {"scale", Property::Scale},
    {"weights", Property::Weights}};

Property propertyOf(std::string_view path) {
  const auto found = std::ranges::find(kPaths, path, [](const auto& row) { return row.first; });
  return found == kPaths.end() ? Property::Other : found->second;
}

/// The number and the rest of `/KIND/NUMBER/REST`; nothing for other pointers.
std::optional<std::pair<int, std::string_view>> elementOf(std::string_view pointer,
                                                          std::string_view kind) {
  if (!pointer.starts_with(kind)) return std::nullopt;
  pointer.remove_prefix(kind.size());
  const auto number = model::takeNumber<int>(pointer);
  if (!number || *number < 0 || !pointer.starts_with('/')) return std::nullopt;
  return std::pair(*number, pointer.substr(1));
}

GltfTarget pointedAt(const tinygltf::Model& model, const std::string& pointer) {
  GltfTarget target;
  target.name = pointer;
  if (const auto node = elementOf(pointer, "/nodes/")) {
    target.nodes = {node->first};
    target.property = node->second == "extensions/KHR_node_visibility/visible"
                          ? Property::Visible
                          : propertyOf(node->second);
  } else if (const auto mesh = elementOf(pointer, "/meshes/"); mesh && mesh->second == "weights") {
    target.property = Property::Weights;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const bool moves = model.nodes[i].mesh == mesh->first && model.nodes[i].weights.empty();
      if (moves) target.nodes.push_back(static_cast<int>(i));
    }
  }
  return target;
}

}  // namespace

GltfTarget gltfTargetOf(const tinygltf::Model& model, const tinygltf::AnimationChannel& channel) {
  if (channel.target_path == "pointer") {
    const auto extension = channel.target_extensions.find("KHR_animation_pointer");
    if (extension != channel.target_extensions.end() && extension->second.Has("pointer") &&
        extension->second.Get("pointer").IsString()) {
      return pointedAt(model, extension->second.Get("pointer").Get<std::string>());
    }
  }
  return {propertyOf(channel.target_path), {channel.target_node}, channel.target_path};
}

}  // namespace t4d::formats
