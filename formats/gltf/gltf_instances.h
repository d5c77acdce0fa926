#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "formats/gltf/gltf_model.h"
#include "formats/input_file.h"

/// The glTF extension EXT_mesh_gpu_instancing: a node places many copies of its mesh.
namespace t4d::formats {

/// How many copies of its mesh a node places: 1 without the extension. Fails if the accessors of
/// the extension do not exist or differ in their counts. Reads no buffer, so that the number can be
/// judged first.
Result<std::size_t> countGltfInstances(const InputFile& file, const tinygltf::Model& model,
                                       int node);

/// The transforms of these copies, from coordinates of the mesh to those of the node: the identity
/// without the extension. Attributes other than TRANSLATION, ROTATION and SCALE are not read. Fails
/// on types that the extension does not allow, on numbers that are not finite, and on quaternions
/// whose length is not 1.
Result<std::vector<Eigen::Affine3d>> readGltfInstances(const InputFile& file,
                                                       const tinygltf::Model& model, int node);

/// The attributes of a node's instances, by name; empty without the extension.
std::vector<std::string> gltfInstanceAttributes(const tinygltf::Node& node);

}  // namespace t4d::formats
