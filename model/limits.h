#pragma once

/// The range of coordinates in which the hypervolume of a 4D mesh, a product of four lengths, is
/// neither infinite nor zero (docs/limits.md).
namespace t4d::model {

/// The largest magnitude of a coordinate or a time.
inline constexpr double kLargestCoordinate = 1e70;

/// The smallest extent of a solid along each axis.
inline constexpr double kSmallestExtent = 1e-70;

}  // namespace t4d::model
