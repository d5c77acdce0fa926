#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/animation/shapes_writer.h"
#include "formats/gltf/gltf_rigid_writer.h"
#include "formats/output_file.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

class UsdStage;

/// True for .usda (text) and .usdz (a package with text).
bool isUsd(const std::filesystem::path& path);

/// Write a USD file: `writeTriangleMeshes` says more. The meshes have been checked; the caller
/// commits the file.
Result<std::vector<std::string>> writeUsdText(OutputFile& file, std::span<const NamedMesh> meshes,
                                              const MeshWriteOptions& options);
Result<std::vector<std::string>> writeUsdPackage(OutputFile& file,
                                                 std::span<const NamedMesh> meshes,
                                                 const MeshWriteOptions& options);

/// Writes one animated USD file with a Mesh for each body. Times are time codes,
/// `timeCodesPerSecond` a second: a flipbook has a frame at each integer. Bodies have time samples
/// of what changes (UsdStage), and are invisible where they do not exist or have no triangles.
class UsdWriter : public ShapesWriter {
 public:
  /// `samples` are those that a body will have. Fails on another extension, and as UsdStage.
  static Result<UsdWriter> create(const std::filesystem::path& path, double timeCodesPerSecond,
                                  std::uint64_t samples, const MeshWriteOptions& options = {});

  UsdWriter(UsdWriter&&) noexcept;
  UsdWriter& operator=(UsdWriter&&) noexcept;
  ~UsdWriter() override;

  /// Adds a frame that shows `meshes`, one for each body, at the time `meshTime` of the mesh. Fails
  /// as soon as the text is likely to become larger than UsdEncoding::maxBytes.
  Result<void> add(double meshTime, std::span<const NamedMesh> meshes);

  Result<void> addBody(const NamedMesh& first, double timeCode,
                       std::span<const std::pair<double, bool>> shown) override;
  Result<void> addShape(const NamedMesh& shape, double timeCode) override;
  /// Adds a body that moves without changing its shape; `seconds` of its keys are time codes.
  Result<void> addRigid(const RigidBody& body);

  /// Writes the file, which plays up to the time code before `end`, or that of the last frame.
  Result<std::vector<std::string>> finish(double end) override;
  Result<std::vector<std::string>> finish();

  /// The file that `finish` has written.
  const std::vector<std::filesystem::path>& files() const;

 private:
  struct State;
  explicit UsdWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The root of a value clip set: a layer that has the files of a series, one for each frame, as the
/// values of its attributes. Programs read a file when they show its frame.
class UsdClipSet {
 public:
  /// `options` as those of the files.
  static Result<UsdClipSet> create(const MeshWriteOptions& options);

  UsdClipSet(UsdClipSet&&) noexcept;
  UsdClipSet& operator=(UsdClipSet&&) noexcept;
  ~UsdClipSet();

  /// Notes what a frame has.
  Result<void> add(std::span<const NamedMesh> meshes);

  /// Writes the layer, whole or not at all. `files` are those of the frames, beside it, in order.
  Result<void> write(const std::filesystem::path& path, std::span<const std::string> files);

 private:
  explicit UsdClipSet(std::unique_ptr<UsdStage> stage);
  std::unique_ptr<UsdStage> stage_;
  std::map<std::string, std::size_t> bodies_;
};

}  // namespace t4d::formats
