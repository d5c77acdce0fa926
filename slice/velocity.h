#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "t4d/error.h"
#include "t4d/slice.h"

namespace t4d::slice {

/// The name of the velocity attribute, registered by the format (SPEC.md, "Kinds of attributes").
inline constexpr std::string_view kVelocity = "velocity";

struct VelocityOptions {
  /// The maximum speed of a vertex, in length units per time unit.
  double most = std::numeric_limits<double>::infinity();
  /// Velocities are written per this many time units, for example those in a second of playback.
  /// Negative if playback is backward.
  double timeUnits = 1;
};

struct VelocityReport {
  /// The sum of area times speed over all triangles: exactly the rate at which the volume of the
  /// slice changes at its time, in volume per time unit.
  double volumeRate = 0;
  double maxSpeed = 0;  ///< largest speed of a vertex, as written: per VelocityOptions::timeUnits
  std::uint64_t clamped = 0;  ///< vertices that were faster than VelocityOptions::most
  /// True if the velocities are those of points of the solid, because the mesh shows these
  /// (SurfaceMotion); false if they are those of its surface.
  bool ofPoints = false;
};

/// Adds the vertex attribute `velocity`, computed from `slice.motion`, which is then taken out of
/// the slice. Slicers set it if asked (WithMotion); without it, nothing is added.
///
/// If the mesh does not show how points move, a vertex gets the smallest velocity that fits the
/// speeds of its triangles along their normals, by least squares weighted by area. At a corner,
/// where normals span space, this is the velocity of the corner; on a flat or smooth part it is the
/// velocity along the normal. Where solids meet or part, speeds of surfaces are unbounded; a
/// velocity above `options.most` is shortened to it.
///
/// If the mesh already has an attribute of that name, it is replaced, and listed in `slice.losses`.
/// Fails if a velocity is beyond the range of doubles.
Result<VelocityReport> addVelocity(Slice& slice, const VelocityOptions& options = {});

}  // namespace t4d::slice
