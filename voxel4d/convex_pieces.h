#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

/// Convex polygons of the plane, cut along segments.
namespace t4d::voxel4d {

/// A polygon is its corners, counter-clockwise.
using ConvexPolygon = std::vector<Eigen::Vector2d>;

struct PlaneSegment {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// The part of a segment in a polygon, grown by `tolerance`. Nothing for a segment that only
/// touches it: that has a few tolerances or less within.
std::optional<PlaneSegment> within(const ConvexPolygon& polygon, const PlaneSegment& segment,
                                   double tolerance);

/// Whether the middle of a segment is farther than `tolerance` from all edges.
bool isCut(const ConvexPolygon& polygon, const PlaneSegment& segment, double tolerance);

/// Cuts a polygon into convex pieces, of which no segment crosses one: each piece that a segment
/// crosses is cut along its whole line. Stops cutting at about `most` pieces.
std::vector<ConvexPolygon> cutAlong(ConvexPolygon polygon,
                                    const std::vector<PlaneSegment>& segments, double tolerance,
                                    std::size_t most);

}  // namespace t4d::voxel4d
