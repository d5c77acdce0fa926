#pragma once

#include <limits>
#include <optional>
#include <span>

#include "t4d/mesh.h"

/// The smallest distance of convex hulls in space-time at equal times.
namespace t4d::measure {

/// The smallest distance of two hulls at equal times.
struct HullDistance {
  double distance = 0;    ///< between pointA and pointB
  double lowerBound = 0;  ///< no two points of the hulls at equal times are nearer
  double time = 0;
  model::Point3 pointA = model::Point3::Zero();
  model::Point3 pointB = model::Point3::Zero();
};

/// The distance of the hulls of two sets of 1 to kMostHullPoints points; nothing if they have no
/// time in common. The differences of points of the hulls at equal times are a convex polytope in
/// space: the section of the difference of the hulls by t = 0. Its point nearest to the origin is
/// found by the algorithm of Gilbert, Johnson and Keerthi (1988), and the plane through that point,
/// perpendicular to its direction, proves the bound. The distance of two hulls that meet may come
/// out as rounding errors.
///
/// Stops as soon as the bound exceeds `enough`; the distance is not the smallest then.
std::optional<HullDistance> distanceOf(std::span<const model::Point4> a,
                                       std::span<const model::Point4> b,
                                       double enough = std::numeric_limits<double>::infinity());

constexpr std::size_t kMostHullPoints = 64;

}  // namespace t4d::measure
