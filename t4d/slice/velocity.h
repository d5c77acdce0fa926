#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "t4d/model/error.h"
#include "t4d/slice/slice.h"

namespace t4d::slice {

/// The name of the attribute, which the format registers (SPEC.md, "Kinds of attributes").
inline constexpr std::string_view kVelocity = "velocity";

struct VelocityOptions {
  /// The most length units per time unit that a vertex may have.
  double most = std::numeric_limits<double>::infinity();
  /// Velocities are written per this many time units: those in a second of playback, for example.
  /// Negative if it plays backward.
  double timeUnits = 1;
};

struct VelocityReport {
  /// The sum of area times speed over all triangles: exactly the rate at which the volume of the
  /// slice changes at its time, in volume per time unit.
  double volumeRate = 0;
  double maxSpeed = 0;        ///< of a vertex, as it is written: per VelocityOptions::timeUnits
  std::uint64_t clamped = 0;  ///< vertices that were faster than VelocityOptions::most
  /// The velocities are those of points of the solid, which the mesh tells (SurfaceMotion); if not,
  /// those of its surface.
  bool ofPoints = false;
};

/// Adds the attribute `velocity` of the vertices and takes `slice.motion`, which a slicer has left
/// (WithMotion); without it, nothing is added.
///
/// Where the mesh does not tell how points move, a vertex gets the smallest velocity that moves it,
/// by least squares weighted by area, along the normals of its triangles at their speeds: at a
/// corner, where normals span space, that of the corner; on a flat or smooth part the velocity
/// along the normal. Where solids meet or part, surfaces move without bound; what is faster than
/// `options.most` gets that speed in its direction.
///
/// An attribute of that name which the mesh has is replaced, and listed in `slice.losses`. Fails if
/// a velocity is beyond the range of doubles.
Result<VelocityReport> addVelocity(Slice& slice, const VelocityOptions& options = {});

}  // namespace t4d::slice
