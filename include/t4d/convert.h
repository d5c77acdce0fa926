#pragma once

/// 4D meshes to animations: flipbooks as glTF and USD.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/surface.h"

namespace t4d::convert {

/// Colours the mesh of a body at a time. The mesh has the name of the body and the attributes of
/// its slice.
using Paint = std::function<void(formats::NamedMesh& mesh, double time)>;

/// Options for the velocities of frames (slice::addVelocity).
struct FrameVelocity {
  double most = std::numeric_limits<double>::infinity();  ///< VelocityOptions::most
  /// VelocityOptions::timeUnits for each frame (playbackRates); 1 for all frames if empty.
  std::vector<double> timeUnits = {};
  bool write = true;  ///< if false, velocities are only for `paint`
};

/// The number of time units of the mesh per second of playback, at each frame of `times`, measured
/// from the previous frame to the next. `times` has at least two elements.
std::vector<double> playbackRates(std::span<const double> times, double framesPerSecond);

struct FrameSlicesReport {
  std::uint64_t frames = 0;
  std::uint64_t triangles = 0;  ///< in all frames together
  /// Whether all slices are light (slice::SliceDetail::Light).
  bool light = false;
  /// The largest distance of a light slice from the exact one; 0 if all slices are exact.
  double distance = 0;
  double maxSpeed = 0;                       ///< largest speed in all frames, as written
  std::uint64_t clamped = 0;                 ///< vertices in all frames together
  std::vector<std::string> notices;          ///< bodies with exact slices where light was requested
  std::vector<std::string> losses;           ///< of attributes
  std::vector<std::filesystem::path> files;  ///< of a flipbook, in order
};

struct FlipbookOptions {
  double framesPerSecond = 24;
  slice::SliceDetail detail = slice::SliceDetail::Light;
  formats::MeshWriteOptions write = {};
  Paint paint = {};
  std::optional<FrameVelocity> velocity = {};
  model::AttributeMeanings meanings = {};  ///< of attributes of bodies that move or morph
};

/// Writes the solids at `times` as one animated glTF (formats::FlipbookWriter) or, depending on the
/// extension, USD (formats::UsdWriter). `losses` of the report include those of
/// formats::writeTriangleMeshes. Fails if forEachFrame or the writer does.
Result<FrameSlicesReport> writeFlipbook(std::span<const model::Body> bodies,
                                        std::span<const double> times,
                                        const std::filesystem::path& path,
                                        const FlipbookOptions& options = {},
                                        const model::Progress& progress = {});

/// Writes a flipbook with one mesh per body, with a morph target (in USD a sample of the points)
/// for each layer of the 4D mesh. `times` determines only the first and last time to show and how
/// long it plays: as long as writeFlipbook with these frames. Light slices between two layers are
/// (1 - s) P + s Q (slice::LightSlicer), and so are meshes with linear weights of two targets. So
/// the flipbook shows the light slice at every moment, not only at frames, in float32.
///
/// A body must consist of prisms of the same triangles, without a gap in time, as a sweep of any
/// motion or deformation does. `options.detail` is not used, and colours and attributes are those
/// of the first time (addFirstLooks). Fails if writeFlipbook does, and for any other body, with the
/// time and the reason.
Result<FrameSlicesReport> writeMorphFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

/// Writes a flipbook with one mesh per body, moved by poses. The file is small, and plays smoothly.
/// `times` determines only the first and last time to show and how long it plays: as long as
/// writeFlipbook with these frames. `options.detail` is not used, and colours and attributes are
/// those of the first time (addFirstLooks). Fails if writeFlipbook does, and if a body is not
/// rigid.
Result<FrameSlicesReport> writeRigidFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::convert
