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

#include "formats/gltf/gltf_writer.h"
#include "formats/output_file.h"
#include "formats/triangle/rounding_loss.h"
#include "formats/triangle/vertex_normals.h"

namespace t4d::formats {

/// `asset.generator` of every file that is written here.
inline constexpr const char* kGltfGenerator = "t4d";
/// The names of materials that stand for none: the second is followed by a number.
inline constexpr const char* kGltfPlainMaterial = "plain";
inline constexpr const char* kGltfColorMaterial = "color ";

/// A glTF file in the making: the document, and one buffer with all numbers. `where` of its errors
/// names the mesh, or is empty; `inFile` adds the path.
class GltfBuilder {
 public:
  enum class Form { Binary, Text };

  /// Makes the root node: unit and axes, and the place of the origin.
  static Result<GltfBuilder> create(Form form, const MeshWriteOptions& options);

  tinygltf::Model& model() { return model_; }

  /// Adds a mesh and returns its number; -1 for one without triangles, which glTF does not allow.
  Result<int> addMesh(const NamedMesh& named) { return addMesh(named, center_); }
  /// `center` is subtracted from the vertices.
  Result<int> addMesh(const NamedMesh& named, const model::Point3& center) {
    Layout layout;
    return addMesh(named, center, layout);
  }

  /// The vertices of a mesh as they are in the file: first those of `vertices`, then copies of some
  /// of them, where triangles of several colours meet.
  struct Layout {
    VerticesWithNormals vertices;
    std::vector<std::uint32_t> copies;
    std::vector<Eigen::Vector3f> places;  ///< steps of the grid, if positions are quantized
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

  /// Adds an accessor of one truth value an element.
  Result<int> addTruths(const std::vector<std::uint8_t>& values);

  /// Names an extension in `extensionsUsed`, and in `extensionsRequired` if it is.
  void use(const std::string& extension, bool required);

  /// Makes a channel animate a property of its node that an extension has:
  /// "EXTENSION/PROPERTY" (KHR_animation_pointer).
  void pointAt(tinygltf::AnimationChannel& channel, const std::string& property);

  /// Bytes of the buffer so far.
  std::uint64_t bufferBytes() const { return bufferBytes_; }
  std::uint64_t maxBytes() const;

  /// Adds an accessor of `count` float32 numbers that are all 0 but for ones at these indices,
  /// which increase.
  Result<int> addOnes(std::size_t count, const std::vector<std::uint32_t>& indices);

  /// Writes all to the file, which the caller commits, and returns what was lost.
  Result<std::vector<std::string>> finish(OutputFile& file);

 private:
  /// A piece of the buffer.
  struct Piece {
    std::vector<unsigned char> bytes = {};  // filled up to a multiple of four
    std::size_t elementBytes = 1;
    bool isTriangles = false;
  };

  struct Numbers {
    std::span<const unsigned char> bytes;
    int componentType;
    int type;
    std::size_t elementBytes;
    std::size_t count;
    bool normalized = false;
  };

  GltfBuilder(Form form, const MeshWriteOptions& options)
      : isText_(form == Form::Text),
        attributes_(options.attributes),
        materialNames_(options.materials),
        normals_(options.normals),
        center_(options.center),
        encoding_(options.gltf),
        rounding_(encoding_.quantization ? RoundingLoss(encoding_.quantization->step())
                                         : RoundingLoss()) {}

  Result<int> addAccessor(const Numbers& numbers, int target);
  /// One with just these bytes and that use is not added again.
  Result<int> addView(const Numbers& numbers, int target);
  Result<int> addIndices(const Layout& layout, std::span<const model::Triangle> triangles);
  /// The places of the vertices of a mesh in the file: float32, or steps of the grid.
  Result<std::vector<Eigen::Vector3f>> placesOf(const NamedMesh& named,
                                                const model::Point3& center);
  Result<int> addPositions(const std::vector<Eigen::Vector3f>& places, bool isMove);
  Result<int> addNormals(const std::vector<Eigen::Vector3f>& normals);
  Result<int> addColors(const NamedMesh& named, const Layout& layout,
                        std::span<const model::Triangle> triangles);
  Result<void> addAttributes(const NamedMesh& named, const Layout& layout,
                             std::span<const model::Triangle> triangles,
                             tinygltf::Primitive& primitive);
  /// A primitive for each material of the triangles.
  Result<void> addPrimitives(const NamedMesh& named, const Layout& layout,
                             std::span<const model::Triangle> triangles,
                             tinygltf::Primitive primitive, tinygltf::Mesh& mesh);
  /// `name` is "" for the material of a mesh without any.
  int materialOf(const NamedMesh& named, const std::string& name);
  /// Names that are not UTF-8, which JSON must be, with _ in place of the wrong bytes.
  void keepNamesInUtf8();
  Result<std::string> documentJson();
  /// Compresses the pieces, and says so in the document.
  Result<void> compress(std::string& document);
  Result<void> writeText(OutputFile& file, std::string_view json) const;
  Result<void> writeBinary(OutputFile& file, std::string_view json) const;
  Error tooLarge() const;

  bool isText_;
  bool attributes_;
  std::vector<std::string> materialNames_;
  std::optional<NormalStyle> normals_;
  model::Point3 center_;
  GltfEncoding encoding_;
  tinygltf::Model model_;
  /// The buffer in pieces, one for each view: growing a single one would need twice its memory.
  std::vector<Piece> pieces_;
  std::uint64_t bufferBytes_ = 0;
  bool hasPointers_ = false;
  std::string otherBuffer_;                          // the entry of a second buffer, if any
  std::unordered_multimap<std::size_t, int> views_;  // by the hash of their bytes
  std::map<std::tuple<int, int, int, bool>, int> accessors_;  // by view and how it is read
  std::map<std::pair<std::string, std::optional<Color>>, int> materials_;
  /// White; by name, and whether vertices are translucent.
  std::map<std::pair<std::string, bool>, int> coloredMaterials_;
  std::vector<std::string> lost_;
  RoundingLoss rounding_;
};

}  // namespace t4d::formats
