#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "formats/gltf/gltf_geometry.h"
#include "formats/gltf/gltf_hierarchy.h"
#include "t4d/surface.h"

namespace t4d::formats {

struct GltfJoint {
  int node = 0;
  Eigen::Affine3d inverseBind = Eigen::Affine3d::Identity();
};

struct GltfInfluence {
  std::uint32_t joint = 0;
  double weight = 0;
};

/// The shape of a node's mesh: the data that moves its vertices.
struct GltfShape {
  int node = 0;
  std::vector<model::Point3> base;
  std::vector<std::vector<model::Point3>> targets;  // displacements of all vertices
  Eigen::VectorXd weights;                          // of the targets, at rest
  const GltfCurve* weightCurve = nullptr;
  std::vector<GltfJoint> joints;                       // none without a skin
  std::vector<std::vector<GltfInfluence>> influences;  // of each vertex

  // Data for bounds: the largest distances from the origin, of the vertices, of each target's
  // displacements, and of the vertices that hang on each joint, in its coordinates.
  double baseReach = 0;
  std::vector<double> targetReach;
  std::vector<double> jointReach;
  double heaviest = 1;  // the largest sum of the magnitudes of a vertex's weights

  bool deforms() const { return !joints.empty() || !targets.empty(); }
  /// The vertices at a time.
  void place(const GltfHierarchy& hierarchy, double time, GltfCurve::Side side,
             std::span<model::Point3> into) const;
  /// A bound of the second derivative of every vertex's place over an interval without keys inside.
  double accelerationBound(const GltfHierarchy& hierarchy, double begin, double end) const;
};

/// Reads the morph targets of a node's mesh and its skin. `parts` are the primitives that `mesh`
/// was made of. Fails on counts that differ, on joints outside the scene, and where points that
/// became one vertex move apart.
Result<GltfShape> readGltfShape(const InputFile& file, const tinygltf::Model& model,
                                const GltfHierarchy& hierarchy, int node,
                                std::span<const GltfGeometry::Part> parts, const LoadedMesh& mesh);

}  // namespace t4d::formats
