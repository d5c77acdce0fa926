#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/surface.h"

namespace t4d::formats {

/// Splits polygons into triangles over the same corners, with the same orientation: every edge of
/// the polygon is an edge of exactly one triangle.
class PolygonTriangulator {
 public:
  /// Ear clipping takes cubic time on hostile polygons; this many comparisons take seconds.
  static constexpr std::uint64_t kMostWork = 1'000'000'000;

  explicit PolygonTriangulator(std::uint64_t mostWork = kMostWork) : workLeft_(mostWork) {}

  /// Appends corners - 2 triangles to `triangles`. `corners` are at least three indices into
  /// `vertices`. Clips ears in the projection along the polygon's Newell normal, so the polygon
  /// need not be convex. Returns false when the polygons so far would take more than seconds.
  bool add(std::span<const model::Point3> vertices, std::span<const std::uint32_t> corners,
           std::vector<model::Triangle>& triangles);

 private:
  struct Corner {
    double x, y;
    std::uint32_t vertex;
    std::uint32_t previous, next;
    bool convex, removed;
  };

  double turn(const Corner& a, const Corner& b, const Corner& c) const;
  void judge(std::uint32_t corner);
  bool isEar(std::uint32_t corner);
  bool clipEars(std::vector<model::Triangle>& triangles);

  std::vector<Corner> corners_;
  std::vector<std::uint32_t> concave_;  // the corners that an ear must not hold
  std::uint64_t workLeft_;
};

}  // namespace t4d::formats
