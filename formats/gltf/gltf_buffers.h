#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "formats/input_file.h"

namespace t4d::formats {

struct GltfBuffers {
  std::vector<tinygltf::Buffer> buffers;
  std::vector<std::filesystem::path> files;  ///< that were read besides the file itself
};

/// Loads the buffers of a glTF 2.0 document: from a Base64 URI, from a file in or below the folder
/// of `file`, or, for the first one of a .glb, from its binary chunk. Bytes beyond `byteLength` are
/// left out. A buffer without a URI, which extensions define, is empty. Fails for other URIs, links
/// that lead out of the folder, and buffers with too few bytes.
Result<GltfBuffers> loadGltfBuffers(const InputFile& file, const nlohmann::json& document,
                                    std::optional<std::string_view> binaryChunk);

}  // namespace t4d::formats
