#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/triangle_mesh_writer.h"
#include "t4d/model/body.h"
#include "t4d/slice/light_slice.h"

namespace t4d::convert {

/// Gives the mesh of a body at a time its colours. The mesh has the name of the body and the
/// attributes of its slice.
using Paint = std::function<void(formats::NamedMesh& mesh, double time)>;

struct FrameSlicesReport {
  std::uint64_t frames = 0;
  std::uint64_t triangles = 0;  ///< in all frames together
  /// All slices consist of the layers' triangles (slice::SliceDetail::Light).
  bool light = false;
  /// The largest distance of a light slice from the exact one; 0 if all are exact.
  double distance = 0;
  std::vector<std::string> notices;  ///< which bodies have exact slices, although light was asked
  std::vector<std::string> losses;   ///< of attributes
  std::vector<std::filesystem::path> files;  ///< of a flipbook, in order
};

/// What forEachFrame fails for before it reads anything: no body has a slab, there are no times, or
/// one is before or after all bodies.
Result<void> checkFrameTimes(std::span<const model::Body> bodies, std::span<const double> times);

/// What is done with a frame, by its number. Stops all when it fails.
using UseFrame =
    std::function<Result<void>(std::size_t frame, std::span<const formats::NamedMesh> meshes)>;

/// The solids at `times`, a mesh for each body, painted if `paint` is given. A body that does not
/// exist at a time is left out of that frame. Slices, paints and calls `prepare`, if it is given,
/// on all threads, in any order; then `take` frame by frame. Times are interpreted as in
/// slice::sliceAtTime. Fails if no body has a slab, if there are no times, and for a time before or
/// after all bodies; of several frames that fail, the first is told.
Result<FrameSlicesReport> forEachFrame(std::span<const model::Body> bodies,
                                       std::span<const double> times, slice::SliceDetail detail,
                                       const UseFrame& take, const Paint& paint = {},
                                       const model::Progress& progress = {},
                                       const UseFrame& prepare = {});

}  // namespace t4d::convert
