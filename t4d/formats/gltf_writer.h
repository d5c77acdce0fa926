#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/triangle_mesh_writer.h"
#include "t4d/model/error.h"

namespace t4d::formats {

/// From the mesh's units and axes to those of glTF: metres, y up, right-handed. It becomes the
/// transform of one root node, above all others, and is stated in that node's `extras`; coordinates
/// are written as they are.
struct GltfPlacement {
  double metresPerUnit = 1;
  bool zUp = false;  ///< the mesh's z is up: turn by -90 degrees about x, which makes it glTF's y
  std::string extras = {};  ///< a JSON object whose members join the root's extras, or ""
};

/// True for .glb (binary) and .gltf (text, with the geometry inside as a data URI).
bool canWriteGltf(const std::filesystem::path& path);

/// Writes a node and a mesh for each mesh that has triangles; the others are left out. Positions
/// are float32; there are no normals, which makes viewers shade flat. With `options.attributes`,
/// vertex attributes of one to four components become float32 attributes `_NAME`.
///
/// Returns a line for each attribute that was asked for and could not be written. Fails like
/// `writeTriangleMeshes`, on geometry that would exceed the 4 GiB of a .glb (1.5 GiB in a .gltf),
/// on names that are not UTF-8, and on extras that are not a JSON object.
Result<std::vector<std::string>> writeGltf(const std::filesystem::path& path,
                                           std::span<const NamedMesh> meshes,
                                           const GltfPlacement& placement = {},
                                           const MeshWriteOptions& options = {});

/// Writes solids whose topology changes over time as glTF that plays everywhere: every frame is a
/// node of its own, shown and hidden by an animation of its scale between 1 and 0 in steps. At rest
/// the first frame is shown.
///
///   frame 0   |----|
///   frame 1        |----|
///   frame 2             |----|
///             0              seconds = frames / framesPerSecond
///
/// The mesh's own time of a frame stands in its node's `extras.time`.
///
/// A frame whose meshes have no triangles has no node; nothing is shown in its turn. Geometry is
/// kept in memory, once, until `finish`.
class FlipbookWriter {
 public:
  /// Fails on a path that cannot be written, and on a rate that is not positive and finite.
  static Result<FlipbookWriter> create(const std::filesystem::path& path,
                                       const GltfPlacement& placement, double framesPerSecond,
                                       const MeshWriteOptions& options = {});

  FlipbookWriter(FlipbookWriter&&) noexcept;
  FlipbookWriter& operator=(FlipbookWriter&&) noexcept;
  ~FlipbookWriter();

  /// Adds a frame that shows `meshes`, one for each body, at the time `meshTime` of the mesh. A
  /// single mesh hangs at the frame's node itself, several at a child each.
  Result<void> add(double meshTime, std::span<const NamedMesh> meshes);

  /// Writes the file; returns the attributes that were lost, as `writeGltf` does. At least one
  /// frame must have been added. Without `finish` no file appears.
  Result<std::vector<std::string>> finish();

 private:
  struct State;
  explicit FlipbookWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace t4d::formats
