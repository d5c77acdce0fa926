#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// A mesh that moves without changing its shape.
struct RigidBody {
  NamedMesh mesh = {};  ///< about the origin of its node
  struct Key {
    double seconds = 0;
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    model::Point3 translation = model::Point3::Zero();
  };
  /// Keys in order of time, at least one. Players turn at a constant speed the shorter way, and
  /// move straight, from one to the next.
  std::vector<Key> keys = {};
  /// Times from which it is shown (true) or hidden, the first 0; empty: always shown.
  std::vector<std::pair<double, bool>> shown = {};
};

/// Writes one animated glTF 2.0 file, .glb or .gltf, with a node and a mesh for each body, moved by
/// channels of rotation and translation; it plays for `seconds`. Fails on another extension, a body
/// without keys, and as writeTriangleMeshes; returns what was lost as that does.
Result<std::vector<std::string>> writeRigidAnimation(const std::filesystem::path& path,
                                                     std::span<const RigidBody> bodies,
                                                     double seconds,
                                                     const MeshWriteOptions& options = {});

}  // namespace t4d::formats
