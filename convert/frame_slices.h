#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/convert.h"

namespace t4d::convert {

/// Options of slicing and colouring frames.
struct FrameSlicing {
  slice::SliceDetail detail = slice::SliceDetail::Exact;
  std::optional<FrameVelocity> velocity = {};
  Paint paint = {};
  /// Whether the attributes other than velocities are kept after painting; only with velocities.
  bool attributes = true;
};

/// Drops the attributes of a slice with velocities that are not to be written. Without velocities,
/// the writer does that.
void dropAttributes(const FrameSlicing& slicing, model::TriangleMesh& mesh);

/// Appends the lines that are not there yet.
void addNewLines(std::span<const std::string> lines, std::vector<std::string>& to);

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
