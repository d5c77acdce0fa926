#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/animation/shapes_writer.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Writes one animated glTF 2.0 file, .glb or .gltf, with a node and a mesh for each body that
/// changes its shape and keeps its triangles. The first shape is the mesh, each later one a morph
/// target of it, and a channel of weights goes from one to the next: at a key one weight is 1 and
/// all others are 0, and between two keys every vertex moves straight, at a constant speed. Shapes
/// are kept in memory, as float32, until `finish`. Attributes are those of the first shape.
class MorphWriter : public ShapesWriter {
 public:
  /// Fails on another extension, and as writeTriangleMeshes.
  static Result<MorphWriter> create(const std::filesystem::path& path,
                                    const MeshWriteOptions& options = {});

  MorphWriter(MorphWriter&&) noexcept;
  MorphWriter& operator=(MorphWriter&&) noexcept;
  ~MorphWriter() override;

  /// Adds a body and its first shape. `shown`: from when on, in seconds, it is shown (true) or
  /// hidden, the first from 0 on; empty: always shown. A mesh without triangles is left out, and so
  /// are its shapes.
  Result<void> addBody(const NamedMesh& first, double seconds,
                       std::span<const std::pair<double, bool>> shown = {}) override;

  /// Adds the shape of the last body at a later time: the same triangles, as many vertices. One
  /// closer to the last than float32 times can tell is left out: it is the same moment.
  Result<void> addShape(const NamedMesh& shape, double seconds) override;

  /// Writes the file, which plays for `seconds`; returns what was lost, as writeTriangleMeshes.
  /// Without `finish` no file appears.
  Result<std::vector<std::string>> finish(double seconds) override;

 private:
  struct State;
  explicit MorphWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace t4d::formats
