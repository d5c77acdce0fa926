#include "formats/gltf/gltf_reader.h"

#include <fmt/format.h>

#include "formats/gltf/gltf_geometry.h"
#include "formats/gltf/gltf_instances.h"
#include "formats/gltf/gltf_looks.h"
#include "formats/gltf/gltf_losses.h"
#include "formats/gltf/gltf_material_names.h"
#include "formats/gltf/gltf_scene.h"
#include "model/amount_text.h"

namespace t4d::formats {
namespace {

/// A mesh and the transform of the node that places it, once or several times.
struct PlacedMesh {
  int mesh;
  Eigen::Affine3d world;
  int node = -1;
};

class RestReader {
 public:
  RestReader(const InputFile& file, const tinygltf::Model& model) : file_(file), model_(model) {}

  Result<LoadedMesh> read(Keep keep) {
    if (auto placed = model_.nodes.empty() ? placeAll() : placeScene(); !placed) {
      return placed.error();
    }
    if (auto good = checkGltfCost(file_, model_, copies_); !good) return good.error();
    GltfGeometry geometry(file_, model_);
    std::size_t hiddenInstances = 0;
    for (const auto& [mesh, world, node] : placed_) {
      const auto instances = instancesOf(node);
      if (!instances) return instances.error();
      for (const Eigen::Affine3d& instance : *instances) {
        if (instance.linear().isZero(0)) {
          ++hiddenInstances;
          continue;
        }
        if (auto done = geometry.addMesh(mesh, world * instance); !done) return done.error();
      }
    }
    GltfLooks looks;
    if (keep == Keep::Attributes) looks = readGltfLooks(file_, model_, geometry.parts());
    FileCorners corners;
    if (!looks.rows.empty()) geometry.keepCornersIn(corners);
    const std::vector<GltfGeometry::Part> parts = geometry.parts();
    std::vector<std::uint32_t> partOf;
    geometry.keepPartsIn(partOf);
    auto loaded = std::move(geometry).finish();
    if (!loaded) return loaded;
    for (const model::Attribute& rows : looks.rows) {
      loaded->mesh.attributes.push_back(
          cornerAttribute(rows, corners.points, corners, loaded->mesh));
    }
    if (keep == Keep::Attributes) {
      GltfMaterialNames materials(model_);
      materials.addTo(loaded->mesh, parts, partOf);
      loaded->materials = materials.names();
      used_.materialNames = !loaded->materials.empty();
    }
    if (hidden_ > 0) {
      loaded->notices.push_back(fmt::format("left out {}: scale zero or not visible",
                                            model::counted(hidden_, "hidden node")));
    }
    if (hiddenInstances > 0) {
      loaded->notices.push_back(fmt::format("left out {}, whose scale is zero",
                                            model::counted(hiddenInstances, "hidden instance")));
    }
    if (sheared_) {
      loaded->notices.emplace_back(
          "matrices of nodes shear the mesh, which glTF does not allow; they are applied as they "
          "are");
    }
    loaded->notices.insert(loaded->notices.end(), looks.notices.begin(), looks.notices.end());
    used_.attributes = std::move(looks.names);
    loaded->losses = gltfLosses(model_, used_);
    return loaded;
  }

 private:
  Result<std::vector<Eigen::Affine3d>> instancesOf(int node) const {
    if (node < 0) return std::vector{Eigen::Affine3d::Identity()};
    return readGltfInstances(file_, model_, node);
  }

  Result<void> placeAll() {
    for (int i = 0; i < static_cast<int>(model_.meshes.size()); ++i) {
      placed_.push_back({i, Eigen::Affine3d::Identity()});
      copies_.push_back({i, 1});
      used_.meshes.insert(i);
    }
    return {};
  }

  Result<void> placeScene() {
    const auto scene = readGltfScene(file_, model_);
    if (!scene) return scene.error();
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
      Eigen::Affine3d world = above.world * node.local;
      if (!node.visible) world.linear().setZero();
      const bool hidden = world.linear().isZero(0);
      hidden_ += hidden && !above.hidden;
      placed[static_cast<std::size_t>(node.index)] = {node.parent, world, hidden};
      const int mesh = model_.nodes[static_cast<std::size_t>(node.index)].mesh;
      if (mesh < 0) continue;
      if (!hidden) {
        const auto count = countGltfInstances(file_, model_, node.index);
        if (!count) return count.error();
        placed_.push_back({mesh, world, node.index});
        copies_.push_back({mesh, *count});
      }
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
  std::vector<PlacedMesh> placed_;
  std::vector<GltfCopies> copies_;  // of each of these
  std::size_t hidden_ = 0;
  bool sheared_ = false;
  GltfUse used_;
};

}  // namespace

Result<LoadedMesh> readGltf(const InputFile& file, Keep keep) {
  auto loaded = loadGltfModel(file);
  if (!loaded) return loaded.error();
  auto mesh = RestReader(file, loaded->model).read(keep);
  if (mesh) mesh->otherFiles = std::move(loaded->bufferFiles);
  return mesh;
}

}  // namespace t4d::formats
