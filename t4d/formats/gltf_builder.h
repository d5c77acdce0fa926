#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/output_file.h"

namespace t4d::formats {

/// A glTF file in the making: the document, and one buffer with all numbers.
class GltfBuilder {
 public:
  struct Limits {
    std::uint64_t binaryBytes = 0xffffffff;  ///< of a .glb, whose length is a 32-bit number
    /// Of the buffer of a .gltf: more would make a document of over 2 GiB, too long for readers.
    std::uint64_t textBufferBytes = std::uint64_t{3} << 29;
  };

  /// Opens the file and makes the root node. `path` has an extension that `canWriteGltf` knows.
  static Result<GltfBuilder> create(const std::filesystem::path& path,
                                    const GltfPlacement& placement, const MeshWriteOptions& options,
                                    const Limits& limits);

  tinygltf::Model& model() { return model_; }

  /// Adds a mesh and returns its number; -1 for one without triangles, which glTF does not allow.
  Result<int> addMesh(const NamedMesh& named);

  /// Adds a node below `parent`, where 0 is the root, and returns its number.
  int addNode(tinygltf::Node node, int parent = 0);

  /// Adds an accessor of float32 numbers, `components` (1 to 4) an element, with their bounds if
  /// asked for, and returns its number. `target` is that of the buffer view, or 0.
  Result<int> addFloats(std::span<const float> numbers, int components, bool bounds, int target);

  /// Writes the file and returns the attributes that were lost.
  Result<std::vector<std::string>> finish();

 private:
  GltfBuilder(OutputFile file, std::filesystem::path path, const MeshWriteOptions& options,
              const Limits& limits);

  Error atPath(Error error) const;
  Result<int> addAccessor(std::span<const unsigned char> bytes, int componentType, int type,
                          std::size_t count, int target);
  Result<int> addIndices(const NamedMesh& named);
  Result<void> addAttributes(const NamedMesh& named, tinygltf::Primitive& primitive);
  Result<std::string> documentJson();
  Result<void> writeText(std::string_view json);
  Result<void> writeBinary(std::string_view json);
  tl::unexpected<Error> tooLarge() const;

  OutputFile file_;
  std::filesystem::path path_;
  bool isText_;
  MeshWriteOptions options_;
  Limits limits_;
  tinygltf::Model model_;
  /// The buffer in pieces: growing a single one would hold it twice.
  std::vector<std::vector<unsigned char>> pieces_;
  std::uint64_t bufferBytes_ = 0;
  std::vector<std::string> lost_;
};

}  // namespace t4d::formats
