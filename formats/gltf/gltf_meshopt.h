#pragma once

#include <algorithm>
#include <iterator>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

/// The glTF extensions EXT_meshopt_compression and KHR_meshopt_compression: buffer views whose
/// bytes meshoptimizer has compressed.
namespace t4d::formats {

inline constexpr std::string_view kMeshoptExtensions[] = {"EXT_meshopt_compression",
                                                          "KHR_meshopt_compression"};

/// A member of the extension of a buffer view that could not be unpacked: why.
inline constexpr const char* kMeshoptProblem = "problem";

inline bool isMeshopt(std::string_view extension) {
  return std::ranges::find(kMeshoptExtensions, extension) != std::ranges::end(kMeshoptExtensions);
}

/// Unpacks the compressed buffer views of a document into new buffers, to which the views then
/// refer. A view that cannot be unpacked keeps its extension, with kMeshoptProblem alone: it only
/// matters where it is needed and its fallback buffer is empty.
void unpackMeshoptViews(nlohmann::json& document, std::vector<tinygltf::Buffer>& buffers);

}  // namespace t4d::formats
