#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/output_file.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// True for .glb (binary) and .gltf (text, with the geometry inside as a data URI).
bool isGltf(const std::filesystem::path& path);

/// Write a glTF 2.0 file, .glb or .gltf: `writeTriangleMeshes` says more. The meshes have been
/// checked; the caller commits the file.
Result<std::vector<std::string>> writeGltfBinary(OutputFile& file,
                                                 std::span<const NamedMesh> meshes,
                                                 const MeshWriteOptions& options);
Result<std::vector<std::string>> writeGltfText(OutputFile& file, std::span<const NamedMesh> meshes,
                                               const MeshWriteOptions& options);

/// Writes solids whose topology changes over time as glTF that plays in any viewer: each frame is a
/// node of its own, and an animation of the nodes' scales, in steps of 1 and 0, shows one at a
/// time. At rest the first frame is shown.
///
///   frame 0   |----|
///   frame 1        |----|
///   frame 2             |----|
///             0              seconds = frames / framesPerSecond
///
/// The mesh's own time of a frame is in its node's `extras.time`.
///
/// A frame whose meshes have no triangles has no node; nothing is shown in its turn. Geometry is
/// kept in memory until its file is written.
///
/// Frames that could make the file larger than GltfEncoding::maxBytes begin another one: a.glb
/// becomes a-1.glb, a-2.glb and so on, each a flipbook of its own that begins at second 0.
class FlipbookWriter {
 public:
  /// Fails on a path that is not .glb or .gltf or cannot be written, and on a rate that is not
  /// positive and finite.
  static Result<FlipbookWriter> create(const std::filesystem::path& path, double framesPerSecond,
                                       const MeshWriteOptions& options = {});

  FlipbookWriter(FlipbookWriter&&) noexcept;
  FlipbookWriter& operator=(FlipbookWriter&&) noexcept;
  ~FlipbookWriter();

  /// Adds a frame that shows `meshes`, one for each body, at the time `meshTime` of the mesh. A
  /// single mesh is the frame's node's own; several have a child node each.
  Result<void> add(double meshTime, std::span<const NamedMesh> meshes);

  /// Writes the file; returns what was lost, as `writeTriangleMeshes` does. At
  /// least one frame must have been added. Without `finish` no file appears.
  Result<std::vector<std::string>> finish();

  /// The files that `finish` has written, in order.
  const std::vector<std::filesystem::path>& files() const;

 private:
  struct State;
  explicit FlipbookWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace t4d::formats
