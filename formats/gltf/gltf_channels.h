#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/gltf/gltf_builder.h"

namespace t4d::formats {

/// A document for meshes that one animation moves. Fails for a path that is not
/// that of a glTF.
Result<GltfBuilder> animationBuilder(const std::filesystem::path& path,
                                     const MeshWriteOptions& options);

/// One animation in the making.
class GltfChannels {
 public:
  /// `builder` must outlive this object.
  GltfChannels(GltfBuilder& builder, const std::string& name) : builder_(builder) {
    animation_.name = name;
  }

  /// Adds a channel with keys at `seconds`, which increase, and the values of an accessor.
  Result<void> add(int node, const char* path, const char* interpolation,
                   std::span<const float> seconds, int values);

  /// Shows or hides a node by its scale: from when on it is shown (true) or hidden, the first from
  /// 0 on, up to `end`. Adds nothing if `shown` is empty.
  Result<void> addShown(int node, std::span<const std::pair<double, bool>> shown, double end);

  /// Adds the animation to the document, if it has channels.
  void finish();

 private:
  GltfBuilder& builder_;
  tinygltf::Animation animation_;
};

}  // namespace t4d::formats
