#include "formats/gltf/gltf_losses.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/gltf/gltf_builder.h"
#include "formats/gltf/gltf_draco.h"
#include "formats/gltf/gltf_instances.h"
#include "formats/gltf/gltf_meshopt.h"
#include "formats/gltf/gltf_model.h"
#include "formats/gltf/gltf_target.h"
#include "model/amount_text.h"

namespace t4d::formats {
namespace {

using model::counted;

bool isPointsOrLines(const tinygltf::Primitive& primitive) {
  return primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode <= TINYGLTF_MODE_LINE_STRIP;
}

/// The word for an attribute of vertices, without a set's number; empty for what is read, and for
/// the joints and weights of skins, which are counted by themselves.
std::string attributeWord(std::string_view name) {
  if (name == "POSITION" || name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")) return {};
  if (name == "NORMAL") return "normals";
  if (name == "TANGENT") return "tangents";
  if (name.starts_with("TEXCOORD_")) return "texture coordinates";
  if (name.starts_with("COLOR_")) return "vertex colors";
  return fmt::format("attribute {}", name);
}

/// Extensions that are read, that change nothing that is read, or that are told by other words.
bool isToldOtherwise(std::string_view extension) {
  return extension == "KHR_mesh_quantization" || extension == kDracoExtension ||
         extension == "EXT_mesh_gpu_instancing" || extension == "KHR_animation_pointer" ||
         extension == "KHR_node_visibility" || isMeshopt(extension) ||
         extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_");
}

class Losses {
 public:
  Losses(const tinygltf::Model& model, const GltfUse& used) : model_(model), used_(used) {}

  std::vector<std::string> list() {
    animation();
    nodes();
    meshes();
    leftOut();
    look();
    return std::move(lines_);
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> text, Values&&... values) {
    lines_.push_back(fmt::format(text, std::forward<Values>(values)...));
  }

  void animation() {
    if (used_.animated) return;
    std::set<int> moved;
    for (const auto& animation : model_.animations) {
      for (const auto& channel : animation.channels) {
        for (const int node : gltfTargetOf(model_, channel).nodes) {
          if (used_.nodes.contains(node)) moved.insert(node);
        }
      }
    }
    if (!moved.empty()) {
      add("the animation of {}: the mesh is as it is at rest", counted(moved.size(), "node"));
    }
  }

  void nodes() {
    std::size_t skinned = 0;
    for (const int index : used_.nodes) {
      const auto* node = elementAt(model_.nodes, index);
      if (node == nullptr) continue;
      skinned += !used_.animated && node->mesh >= 0 && node->skin >= 0;
      if (node->mesh < 0) continue;
      for (const std::string& name : gltfInstanceAttributes(*node)) instanceAttribute(name);
    }
    if (skinned > 0) {
      add("the skin of {}: the mesh is as it is before skinning", counted(skinned, "node"));
    }
  }

  void meshes() {
    std::size_t morphed = 0;
    std::size_t pointsOrLines = 0;
    for (const int index : used_.meshes) {
      const auto* mesh = elementAt(model_.meshes, index);
      if (mesh == nullptr) continue;
      morphed +=
          std::ranges::any_of(mesh->primitives, [](const auto& p) { return !p.targets.empty(); });
      for (const auto& primitive : mesh->primitives) {
        pointsOrLines += isPointsOrLines(primitive);
        if (isPointsOrLines(primitive)) continue;
        for (const auto& [name, accessor] : primitive.attributes) attribute(name);
        const auto* material = elementAt(model_.materials, primitive.material);
        if (material != nullptr) materials_.insert(primitive.material);
      }
    }
    if (morphed > 0 && !used_.animated) {
      add("the morph targets of {}: its base shape is used", counted(morphed, "mesh", "meshes"));
    }
    if (pointsOrLines > 0) add("{} of points or lines", counted(pointsOrLines, "set"));
  }

  void attribute(const std::string& name) {
    if (used_.attributes.contains(name)) return;
    const std::string word = attributeWord(name);
    const bool isFurther =
        (name.starts_with("TEXCOORD_") && used_.attributes.contains("TEXCOORD_0")) ||
        (name.starts_with("COLOR_") && used_.attributes.contains("COLOR_0"));
    addToLook(isFurther ? "further " + word : word);
  }

  void instanceAttribute(const std::string& name) {
    if (name == "TRANSLATION" || name == "ROTATION" || name == "SCALE") return;
    addToLook(fmt::format("attribute {} of instances", name));
  }

  void addToLook(const std::string& word) {
    if (!word.empty() && std::ranges::find(look_, word) == look_.end()) look_.push_back(word);
  }

  void leftOut() {
    const std::size_t unused = model_.meshes.size() - used_.meshes.size();
    if (model_.scenes.size() > 1) {
      add("{} besides {}", counted(model_.scenes.size() - 1, "scene"),
          used_.scene ? "the one that is read" : "the default one");
    }
    if (unused > 0) add("{} outside the scene", counted(unused, "mesh", "meshes"));
  }

  /// Normals, texture coordinates, materials, ...: one line.
  void look() {
    // Every file that this library writes has one grey material.
    if (!materials_.empty() && model_.asset.generator != kGltfGenerator) {
      const std::string count = counted(materials_.size(), "material");
      look_.push_back(used_.materialNames ? "the look of " + count : count);
    }
    if (!model_.images.empty()) look_.push_back(counted(model_.images.size(), "image"));
    if (!model_.cameras.empty()) look_.push_back(counted(model_.cameras.size(), "camera"));
    for (const std::string& extension : model_.extensionsUsed) {
      if (!isToldOtherwise(extension)) look_.push_back("extension " + extension);
    }
    if (look_.empty()) return;
    std::vector<std::string> kept(used_.attributes.begin(), used_.attributes.end());
    if (used_.materialNames) kept.emplace_back("names of materials");
    const std::string read =
        kept.empty() ? "positions and triangles"
                     : fmt::format("positions, triangles and {}", fmt::join(kept, ", "));
    add("{}: only {} are read", fmt::join(look_, ", "), read);
  }

  const tinygltf::Model& model_;
  const GltfUse& used_;
  std::vector<std::string> lines_;
  std::vector<std::string> look_;
  std::set<int> materials_;
};

}  // namespace

std::vector<std::string> gltfLosses(const tinygltf::Model& model, const GltfUse& used) {
  return Losses(model, used).list();
}

}  // namespace t4d::formats
