#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "formats/gltf/gltf_curve.h"
#include "formats/gltf/gltf_scene.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// A node and the curves that move it.
struct GltfMovingNode {
  int parent = -1;
  Eigen::Affine3d local;  ///< at rest
  model::Point3 translation = model::Point3::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  model::Point3 scale = model::Point3::Ones();
  const GltfCurve* translations = nullptr;
  const GltfCurve* rotations = nullptr;
  const GltfCurve* scales = nullptr;
  const GltfCurve* visibles = nullptr;
  bool visible = true;  ///< where no curve says so (KHR_node_visibility)

  bool moves() const {
    return translations != nullptr || rotations != nullptr || scales != nullptr;
  }
  Eigen::Affine3d at(double time, GltfCurve::Side side) const;
  /// The bound of the place of a point that moves within this node's coordinates: x -> T + R S x.
  CurveBound bound(const CurveBound& point, double begin, double end) const;
};

/// The nodes of a scene and everything that moves them.
struct GltfHierarchy {
  std::vector<std::unique_ptr<GltfCurve>> curves;
  std::vector<std::optional<GltfMovingNode>> nodes;  ///< by index; nothing outside the scene
  std::vector<const GltfCurve*> weights;  ///< of the morph targets, by node; null where they rest
  double end = 0;                         ///< the time of the last key
  std::size_t keysBeforeZero = 0;
  std::vector<std::string> others;  ///< what channels move besides nodes: paths, or pointers

  bool has(int index) const {
    return index >= 0 && static_cast<std::size_t>(index) < nodes.size() &&
           nodes[static_cast<std::size_t>(index)].has_value();
  }
  const GltfMovingNode& node(int index) const { return *nodes[static_cast<std::size_t>(index)]; }

  /// Maps the coordinates of a node to those of the scene.
  Eigen::Affine3d world(int index, double time, GltfCurve::Side side) const;
  /// Whether the node and all above it are visible (KHR_node_visibility).
  bool isVisible(int index, double time, GltfCurve::Side side) const;
  /// The bound for the place in the scene of a point that moves within a node's coordinates.
  CurveBound bound(int index, CurveBound point, double begin, double end) const;
};

/// Reads what animations, of which there is at least one, do together with the nodes of a scene.
/// Fails on channels that the specification does not allow, on two that move the same, if nothing
/// moves, and where a scale shrinks to zero or through it.
Result<GltfHierarchy> readGltfHierarchy(const InputFile& file, const tinygltf::Model& model,
                                        std::span<const GltfNode> scene,
                                        std::span<const int> animations);

}  // namespace t4d::formats
