#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <tiny_gltf.h>

#include "formats/input_file.h"
#include "t4d/error.h"

/// Checks before and after tinygltf parses a file.
namespace t4d::formats {

struct GltfModel {
  tinygltf::Model model;
  std::vector<std::filesystem::path> bufferFiles;  ///< that were read besides the file itself
};

/// Parses a glTF 2.0 file, text or binary, and loads its buffers, which may be files in or below
/// its folder; what meshoptimizer and Draco have compressed is unpacked. Does not load images.
/// Fails on what tinygltf cannot parse, keys that occur twice in an object, negative offsets, other
/// versions, required extensions that would change the geometry, and as unpackDracoPrimitives.
Result<GltfModel> loadGltfModel(const InputFile& file);

/// The remedy for an extension that is not supported: PlainGltf for those that common programs take
/// out.
Remedy gltfRemedyFor(std::string_view extension);

/// The numbers of an accessor, element after element, `components` each: normalised integers are
/// mapped to [-1, 1] or [0, 1], sparse values are substituted. Every range is checked against the
/// buffers. `where` of an error names the accessor.
Result<std::vector<double>> readGltfAccessor(const InputFile& file, const tinygltf::Model& model,
                                             int accessor, int components);

/// The place FILE: KIND[INDEX], for `where` of errors; `member` follows, as in `.channels[0]`.
Place gltfElement(const InputFile& file, const char* kind, int index,
                  const std::string& member = {});

/// The element that a glTF index refers to; null if there is none.
template <class T>
const T* elementAt(const std::vector<T>& all, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < all.size()
             ? &all[static_cast<std::size_t>(index)]
             : nullptr;
}

}  // namespace t4d::formats
