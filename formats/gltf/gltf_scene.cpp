#include "formats/gltf/gltf_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "formats/gltf/gltf_geometry.h"

namespace t4d::formats {
namespace {

bool isVisible(const tinygltf::Node& node) {
  const auto found = node.extensions.find("KHR_node_visibility");
  if (found == node.extensions.end() || !found->second.Has("visible")) return true;
  const tinygltf::Value& visible = found->second.Get("visible");
  return !visible.IsBool() || visible.Get<bool>();
}

class Walk {
 public:
  Walk(const InputFile& file, const tinygltf::Model& model) : file_(file), model_(model) {}

  Result<GltfScene> from(std::optional<int> scene) {
    const auto first = roots(scene);
    if (!first) return first.error();
    struct Visit {
      int node;
      int parent;
    };
    // An explicit stack: a chain of nodes may be too long for recursion.
    std::vector<Visit> open;
    const auto push = [&](const std::vector<int>& nodes, int parent) {
      for (auto i = nodes.rbegin(); i != nodes.rend(); ++i) open.push_back({*i, parent});
    };
    push(*first, -1);
    std::vector<bool> visited(model_.nodes.size(), false);
    while (!open.empty()) {
      const auto [index, parent] = open.back();
      open.pop_back();
      const auto* node = elementAt(model_.nodes, index);
      if (node == nullptr) {
        return invalid(fmt::format("does not exist; there are {}", model_.nodes.size()),
                       gltfElement(file_, "nodes", index));
      }
      if (visited[static_cast<std::size_t>(index)]) {
        return invalid("has two parents or is its own ancestor",
                       gltfElement(file_, "nodes", index));
      }
      visited[static_cast<std::size_t>(index)] = true;
      const auto local = localTransform(*node, index);
      if (!local) return local.error();
      scene_.nodes.push_back({index, parent, *local, isVisible(*node)});
      push(node->children, index);
    }
    return std::move(scene_);
  }

 private:
  /// The root nodes: those of the default scene, or all without a parent.
  Result<std::vector<int>> roots(std::optional<int> chosen) const {
    if (!model_.scenes.empty()) {
      const int index = chosen.value_or(std::max(model_.defaultScene, 0));
      const auto* scene = elementAt(model_.scenes, index);
      if (scene == nullptr) {
        return invalid(fmt::format("does not exist; there are {}", model_.scenes.size()),
                       gltfElement(file_, "scenes", index));
      }
      return scene->nodes;
    }
    std::vector<bool> isChild(model_.nodes.size(), false);
    for (const auto& node : model_.nodes) {
      for (const int child : node.children) {
        if (elementAt(model_.nodes, child) != nullptr)
          isChild[static_cast<std::size_t>(child)] = true;
      }
    }
    std::vector<int> found;
    for (std::size_t i = 0; i < isChild.size(); ++i) {
      if (!isChild[i]) found.push_back(static_cast<int>(i));
    }
    return found;
  }

  Result<Eigen::Affine3d> localTransform(const tinygltf::Node& node, int index) {
    const auto hasSize = [](const std::vector<double>& numbers, std::size_t size) {
      return numbers.empty() || numbers.size() == size;
    };
    if (!hasSize(node.matrix, 16) || !hasSize(node.translation, 3) || !hasSize(node.rotation, 4) ||
        !hasSize(node.scale, 3)) {
      return invalid("a transform with the wrong number of values",
                     gltfElement(file_, "nodes", index));
    }
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (!node.matrix.empty()) {
      const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
      if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
        return invalid("a matrix whose last row is not 0 0 0 1",
                       gltfElement(file_, "nodes", index));
      }
      transform.matrix() = matrix;
      // glTF allows products of a scale, a rotation and a translation only.
      const Eigen::Matrix3d products = transform.linear().transpose() * transform.linear();
      const Eigen::Vector3d squares = products.diagonal();
      constexpr double kSquare = 1e-3;  // far above the rounding of float32
      for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {2, 0}}) {
        if (std::abs(products(i, j)) > kSquare * std::sqrt(squares[i] * squares[j])) {
          scene_.sheared = true;
        }
      }
      return transform;
    }
    if (!node.translation.empty()) {
      transform.translation() = Eigen::Map<const Eigen::Vector3d>(node.translation.data());
    }
    if (!node.rotation.empty()) {
      const auto& r = node.rotation;
      const Eigen::Quaterniond rotation(r[3], r[0], r[1], r[2]);
      constexpr double kUnit = 1e-2;  // far above the rounding of float32
      if (!(std::abs(rotation.norm() - 1) <= kUnit)) {
        return invalid(
            fmt::format("a rotation by a quaternion of length {}, expected 1", rotation.norm()),
            gltfElement(file_, "nodes", index));
      }
      transform.linear() = rotation.normalized().toRotationMatrix();
    }
    if (!node.scale.empty()) {
      transform.linear() *= Eigen::Map<const Eigen::Vector3d>(node.scale.data()).asDiagonal();
    }
    return transform;
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  GltfScene scene_;
};

}  // namespace

Result<GltfScene> readGltfScene(const InputFile& file, const tinygltf::Model& model,
                                std::optional<int> scene) {
  return Walk(file, model).from(scene);
}

}  // namespace t4d::formats
