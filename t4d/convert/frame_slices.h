#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
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

/// The velocities that frames get (slice::addVelocity).
struct FrameVelocity {
  double most = std::numeric_limits<double>::infinity();  ///< VelocityOptions::most
  /// VelocityOptions::timeUnits of each frame (playbackRates); 1 for all if empty.
  std::vector<double> timeUnits = {};
  bool write = true;  ///< if not, they are only there for `paint`
};

/// How many time units of the mesh pass in a second of playback, at each frame of `times`: from the
/// frame before to the one after. `times` has more than one.
std::vector<double> playbackRates(std::span<const double> times, double framesPerSecond);

/// What a frame is made of.
struct FrameSlicing {
  slice::SliceDetail detail = slice::SliceDetail::Exact;
  std::optional<FrameVelocity> velocity = {};
  Paint paint = {};
  /// With velocities: whether the mesh's own attributes stay after painting.
  bool attributes = true;
};

/// Leaves out the attributes of a slice with velocities that are not to be written; without
/// velocities that is left to the writer.
void dropAttributes(const FrameSlicing& slicing, model::TriangleMesh& mesh);

struct FrameSlicesReport {
  std::uint64_t frames = 0;
  std::uint64_t triangles = 0;  ///< in all frames together
  /// All slices consist of the layers' triangles (slice::SliceDetail::Light).
  bool light = false;
  /// The largest distance of a light slice from the exact one; 0 if all are exact.
  double distance = 0;
  double maxSpeed = 0;        ///< of FrameVelocity: the largest of all frames, as it is written
  std::uint64_t clamped = 0;  ///< vertices in all frames together
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

/// The solids at `times`, a mesh for each body. A body that does not
/// exist at a time is left out of that frame. Slices, paints and calls `prepare`, if it is given,
/// on all threads, in any order; then `take` frame by frame. Times are interpreted as in
/// slice::sliceAtTime. Fails if no body has a slab, if there are no times, and for a time before or
/// after all bodies; of several frames that fail, the first is told.
Result<FrameSlicesReport> forEachFrame(std::span<const model::Body> bodies,
                                       std::span<const double> times, const FrameSlicing& slicing,
                                       const UseFrame& take, const model::Progress& progress = {},
                                       const UseFrame& prepare = {});

}  // namespace t4d::convert
