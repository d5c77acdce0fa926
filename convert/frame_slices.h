#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle/triangle_mesh_writer.h"
#include "model/body.h"
#include "slice/light_slice.h"

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

/// How frames are sliced and coloured.
struct FrameSlicing {
  slice::SliceDetail detail = slice::SliceDetail::Exact;
  std::optional<FrameVelocity> velocity = {};
  Paint paint = {};
  /// With velocities: whether the other attributes are kept after painting.
  bool attributes = true;
};

/// Drops the attributes of a slice with velocities that are not to be written. Without velocities,
/// the writer does that.
void dropAttributes(const FrameSlicing& slicing, model::TriangleMesh& mesh);

/// Appends the lines that are not there yet.
void addNewLines(std::span<const std::string> lines, std::vector<std::string>& to);

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

/// The first check of forEachFrame. Fails if no body has a slab, if there are no times, and if a
/// time is before or after all bodies.
Result<void> checkFrameTimes(std::span<const model::Body> bodies, std::span<const double> times);

/// Processes a frame, given its number. An error ends forEachFrame.
using UseFrame =
    std::function<Result<void>(std::size_t frame, std::span<const formats::NamedMesh> meshes)>;

/// Makes the solids at `times`, a mesh for each body. A body that does not exist at a time is left
/// out of that frame. Slices, paints and calls `prepare`, if given, on all threads, in any order;
/// then calls `take` frame by frame. Times are interpreted as in slice::sliceAtTime. Fails if
/// checkFrameTimes does; if several frames fail, the error is that of the first.
Result<FrameSlicesReport> forEachFrame(std::span<const model::Body> bodies,
                                       std::span<const double> times, const FrameSlicing& slicing,
                                       const UseFrame& take, const model::Progress& progress = {},
                                       const UseFrame& prepare = {});

}  // namespace t4d::convert
