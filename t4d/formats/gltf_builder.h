#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include <tiny_gltf.h>

#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/rounding_loss.h"

namespace t4d::formats {

/// `asset.generator` of every file that is written here.
inline constexpr const char* kGltfGenerator = "t4d";

/// A glTF file in the making: the document, and one buffer with all numbers. `where` of its errors
/// names the mesh, or is empty; `inFile` adds the path.
class GltfBuilder {
 public:
  struct Limits {
    std::uint64_t binaryBytes = 0xffffffff;  ///< of a .glb, whose length is a 32-bit number
    /// Of the buffer of a .gltf: more would make a document of over 2 GiB, too large for readers.
    std::uint64_t textBufferBytes = std::uint64_t{3} << 29;
  };

  enum class Form { Binary, Text };

  /// Makes the root node: unit and axes, and the place of the origin.
  static Result<GltfBuilder> create(Form form, const MeshWriteOptions& options,
                                    const Limits& limits);

  tinygltf::Model& model() { return model_; }

  /// Adds a mesh and returns its number; -1 for one without triangles, which glTF does not allow.
  Result<int> addMesh(const NamedMesh& named) { return addMesh(named, center_); }
  /// `center` is subtracted from the vertices.
  Result<int> addMesh(const NamedMesh& named, const model::Point3& center) {
    Layout layout;
    return addMesh(named, center, layout);
  }

  /// The vertices of a mesh as they are in the file.
  struct Layout {
    VerticesWithNormals vertices;
    std::vector<Eigen::Vector3f> places;
  };
  Result<int> addMesh(const NamedMesh& named, const model::Point3& center, Layout& layout);
  /// Adds a morph target to a mesh of that layout, which makes it `shape`: the same triangles with
  /// other vertices. Normals are shared where they are in the layout.
  Result<void> addTarget(int mesh, const Layout& layout, const NamedMesh& shape,
                         const model::Point3& center);
  const model::Point3& center() const { return center_; }

  /// Adds a node below `parent`, where 0 is the root, and returns its number.
  int addNode(tinygltf::Node node, int parent = 0);

  /// Adds an accessor of float32 numbers, `components` (1 to 4) an element, with their bounds if
  /// asked for, and returns its number. `target` is that of the buffer view, or 0. Numbers that are
  /// there already are not added again: frames often share triangles.
  Result<int> addFloats(std::span<const float> numbers, int components, bool bounds, int target);

  /// Adds an accessor of `count` float32 numbers that are all 0 but for ones at these indices,
  /// which increase.
  Result<int> addOnes(std::size_t count, const std::vector<std::uint32_t>& indices);

  /// Writes all to the file, which the caller commits, and returns what was lost.
  Result<std::vector<std::string>> finish(OutputFile& file);

 private:
  GltfBuilder(Form form, const MeshWriteOptions& options, const Limits& limits)
      : isText_(form == Form::Text),
        attributes_(options.attributes),
        normals_(options.normals),
        center_(options.center),
        limits_(limits) {}

  Result<int> addAccessor(std::span<const unsigned char> bytes, int componentType, int type,
                          std::size_t count, int target);
  /// One with just these bytes and that use is not added again.
  Result<int> addView(std::span<const unsigned char> bytes, int target);
  Result<int> addIndices(const VerticesWithNormals& vertices);
  Result<void> addAttributes(const NamedMesh& named, const VerticesWithNormals& vertices,
                             tinygltf::Primitive& primitive);
  int materialOf(const std::optional<Color>& color);
  Result<std::string> documentJson();
  Result<void> writeText(OutputFile& file, std::string_view json) const;
  Result<void> writeBinary(OutputFile& file, std::string_view json) const;
  tl::unexpected<Error> tooLarge() const;

  bool isText_;
  bool attributes_;
  std::optional<NormalStyle> normals_;
  model::Point3 center_;
  Limits limits_;
  tinygltf::Model model_;
  /// The buffer in pieces, one for each view: growing a single one would need twice its memory.
  std::vector<std::vector<unsigned char>> pieces_;
  std::uint64_t bufferBytes_ = 0;
  std::unordered_multimap<std::size_t, int> views_;     // by the hash of their bytes
  std::map<std::tuple<int, int, int>, int> accessors_;  // by view, component type and type
  std::map<std::optional<Color>, int> materials_;
  std::vector<std::string> lost_;
  RoundingLoss rounding_;
};

}  // namespace t4d::formats
