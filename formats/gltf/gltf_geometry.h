#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "formats/gltf/gltf_model.h"
#include "formats/triangle/mesh_builder.h"

namespace t4d::formats {

/// Joins the triangles of glTF meshes into one triangle mesh.
class GltfGeometry {
 public:
  /// Both must outlive this object.
  GltfGeometry(const InputFile& file, const tinygltf::Model& model);
  GltfGeometry(const GltfGeometry&) = delete;
  GltfGeometry& operator=(const GltfGeometry&) = delete;

  /// Adds the triangles of a mesh, moved by `world`; one that mirrors reverses them.
  Result<void> addMesh(int mesh, const Eigen::Affine3d& world);

  /// A primitive whose positions have been added, in order.
  struct Part {
    const tinygltf::Primitive* primitive;
    std::size_t pointCount;
    Eigen::Matrix3d linear;  ///< that its positions were moved by
  };
  const std::vector<Part>& parts() const { return parts_; }

  /// Calls MeshBuilder::keepCornersIn.
  void keepCornersIn(FileCorners& corners) { builder_.keepCornersIn(corners); }

  /// For each triangle of the mesh that `finish` makes, the number of its part. Filled by `finish`.
  void keepPartsIn(std::vector<std::uint32_t>& parts) { builder_.keepPartsIn(parts); }

  /// Calls MeshBuilder::finish.
  Result<LoadedMesh> finish() && { return std::move(builder_).finish(); }

 private:
  Result<void> readPrimitive(const tinygltf::Primitive& primitive, const Eigen::Affine3d& world);
  Result<std::size_t> addPoints(int accessor, const Eigen::Affine3d& world);
  Result<std::vector<std::uint64_t>> cornersOf(const tinygltf::Primitive& primitive,
                                               std::size_t pointCount);
  Result<void> addTriangles(int mode, const std::vector<std::uint64_t>& corners,
                            std::uint64_t first, bool mirrored);

  const InputFile& file_;
  const tinygltf::Model& model_;
  std::vector<Place> places_;
  std::map<int, std::size_t> placesOf_;  // a mesh's first
  std::size_t place_ = 0;                // the present one
  std::vector<Part> parts_;
  MeshBuilder builder_;
};

/// A number of copies of a mesh.
struct GltfCopies {
  int mesh;
  std::size_t count;
};

/// Fails when these copies have together more numbers than any honest file: a few bytes of JSON can
/// instantiate a mesh any number of times.
Result<void> checkGltfCost(const InputFile& file, const tinygltf::Model& model,
                           std::span<const GltfCopies> copies);

/// The most morph targets of a mesh's primitives; 0 without the mesh.
int gltfTargetCount(const tinygltf::Model& model, int mesh);

}  // namespace t4d::formats
