#include "t4d/formats/gltf_reader.h"

#include <fmt/format.h>

#include "t4d/formats/gltf_geometry.h"
#include "t4d/formats/gltf_losses.h"
#include "t4d/formats/gltf_scene.h"

namespace t4d::formats {
namespace {

/// A mesh and the transform that places it.
struct Instance {
  int mesh;
  Eigen::Affine3d world;
};

class RestReader {
 public:
  RestReader(const InputFile& file, const tinygltf::Model& model) : file_(file), model_(model) {}

  Result<LoadedMesh> read() {
    if (auto placed = model_.nodes.empty() ? placeAll() : placeScene(); !placed) {
      return pass(placed.error());
    }
    std::vector<int> meshes;
    for (const Instance& instance : instances_) meshes.push_back(instance.mesh);
    if (auto good = checkGltfCost(file_, model_, meshes); !good) return pass(good.error());
    GltfGeometry geometry(file_, model_);
    for (const auto& [mesh, world] : instances_) {
      if (auto done = geometry.addMesh(mesh, world); !done) return pass(done.error());
    }
    auto loaded = std::move(geometry).finish();
    if (!loaded) return loaded;
    if (hidden_ > 0) {
      loaded->notices.push_back(
          fmt::format("left out {}, whose scale is zero", counted(hidden_, "hidden node")));
    }
    if (sheared_ > 0) {
      loaded->notices.emplace_back(
          "matrices of nodes shear the mesh, which glTF does not allow; they are applied as they "
          "are");
    }
    loaded->losses = gltfLosses(model_, used_);
    return loaded;
  }

 private:
  Result<void> placeAll() {
    for (int i = 0; i < static_cast<int>(model_.meshes.size()); ++i) {
      instances_.push_back({i, Eigen::Affine3d::Identity()});
      used_.meshes.insert(i);
    }
    return {};
  }

  Result<void> placeScene() {
    const auto scene = readGltfScene(file_, model_);
    if (!scene) return pass(scene.error());
    sheared_ = scene->sheared;
    struct Placed {
      int parent = -1;
      Eigen::Affine3d world = Eigen::Affine3d::Identity();
      bool hidden = false;
    };
    std::vector<Placed> placed(model_.nodes.size());
    for (const GltfNode& node : scene->nodes) {
      const Placed above =
          node.parent < 0 ? Placed{} : placed[static_cast<std::size_t>(node.parent)];
      const Eigen::Affine3d world = above.world * node.local;
      const bool hidden = world.linear().isZero(0);
      hidden_ += hidden && !above.hidden;
      placed[static_cast<std::size_t>(node.index)] = {node.parent, world, hidden};
      const int mesh = model_.nodes[static_cast<std::size_t>(node.index)].mesh;
      if (mesh < 0) continue;
      if (!hidden) instances_.push_back({mesh, world});
      used_.meshes.insert(mesh);
      // An insertion that finds the node has found its ancestors, too.
      for (int i = node.index; i >= 0 && used_.nodes.insert(i).second;) {
        i = placed[static_cast<std::size_t>(i)].parent;
      }
    }
    return {};
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  std::vector<Instance> instances_;
  std::size_t hidden_ = 0;
  std::size_t sheared_ = 0;
  GltfUse used_;
};

}  // namespace

Result<LoadedMesh> readGltf(const InputFile& file) {
  auto loaded = loadGltfModel(file);
  if (!loaded) return pass(loaded.error());
  auto mesh = RestReader(file, loaded->model).read();
  if (mesh) mesh->otherFiles = std::move(loaded->bufferFiles);
  return mesh;
}

}  // namespace t4d::formats
