#pragma once

#include <vector>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "formats/input_file.h"

/// The glTF extension KHR_draco_mesh_compression: primitives whose attributes and indices Draco has
/// compressed.
namespace t4d::formats {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Unpacks the compressed primitives of a document into new buffers, to which new accessors refer,
/// and removes the extension from all primitives. Those that also have the same data plain keep it.
/// Morph targets are never compressed: theirs are the points in the order in which Draco gives
/// them. Fails, naming the primitive, on what the extension does not allow, and as dracoUnpacked.
Result<void> unpackDracoPrimitives(const InputFile& file, nlohmann::json& document,
                                   std::vector<tinygltf::Buffer>& buffers);

}  // namespace t4d::formats
