#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::slice {

/// The position of a vertex relative to a hyperplane. A vertex on it counts as above or as not
/// above.
struct Side {
  static constexpr std::uint8_t kAbove = 1;
  static constexpr std::uint8_t kOn = 2;
};

/// The section of a slab by a hyperplane, found by marching tetrahedra: a surface without
/// coordinates. It depends only on the cells and on the sides of their vertices.
struct Cut {
  /// A point of the cut: on the edge between two vertices of the slab, one of which is above, or at
  /// a single vertex (both equal).
  struct Point {
    std::uint32_t below;
    std::uint32_t above;
    bool operator==(const Point&) const = default;
  };
  std::vector<Point> points;  ///< without duplicates; in the order of the slab if all are vertices
  /// The triangles between points. They face away from the solid in axes e1, e2, e3 of the
  /// hyperplane if (e1, e2, e3, normal) is oriented like (x, y, z, t).
  std::vector<model::Triangle> triangles;
  std::vector<std::uint32_t> cells;  ///< for each triangle, the cell that it was cut from
};

/// Numbers points in the order of the first request for each. Each vertex has a chain of the points
/// on edges to vertices above it, whose entries are close together in memory because the cells are.
/// A chain that would be longer than a few dozen, as at the apex of a cone, continues in a hash
/// table. Most points were requested shortly before, so recent ones are tried first.
class PointNumbers {
 public:
  /// Appends new points to `points`, which must outlive this object.
  PointNumbers(std::size_t vertexCount, std::vector<Cut::Point>& points)
      : first_(vertexCount, model::kNoIndex), points_(points) {}

  std::uint32_t of(const Cut::Point& point) {
    Recent& recent = recent_[(point.below * 7 + point.above * 31) % recent_.size()];
    if (recent.point == point) return recent.number;
    recent = {point, find(point)};
    return recent.number;
  }

 private:
  struct Recent {
    Cut::Point point = {model::kNoIndex, model::kNoIndex};
    std::uint32_t number = model::kNoIndex;
  };
  struct Link {
    std::uint32_t above;
    std::uint32_t next;
  };

  std::uint32_t find(const Cut::Point& point);
  std::uint32_t add(const Cut::Point& point);

  std::vector<std::uint32_t> first_;  // per vertex, model::kNoIndex if no edge is cut
  std::vector<Link> links_;           // per point, in the chain
  std::vector<Cut::Point>& points_;
  std::unordered_map<std::uint64_t, std::uint32_t> others_;
  std::array<Recent, 256> recent_;
};

/// If all points are vertices, sorts them in the order of the slab, so that the slice at a layer is
/// numbered like the input. The order is returned: the old number of each point.
std::vector<std::uint32_t> numberAsInSlab(Cut& cut);

/// Cuts some of the cells of a slab, in their order. Triangles that lose a corner because two cut
/// points are the same vertex are dropped, and so are points that no triangle has.
class CellCutter {
 public:
  /// `sides` has a value for each vertex; only those of vertices of cells that are cut are used.
  CellCutter(std::span<const model::Cell> cells, std::span<const std::uint8_t> sides)
      : cells_(cells), sides_(sides), numbers_(sides.size(), cut_.points) {}
  CellCutter(const CellCutter&) = delete;
  CellCutter& operator=(const CellCutter&) = delete;

  void add(std::uint32_t begin, std::uint32_t end);
  Cut finish();

 private:
  void addSection(const model::Cell& cell, unsigned pattern, std::uint32_t index);
  unsigned patternOf(const model::Cell& cell) const {
    return (sides_[cell[0]] & 1U) | (sides_[cell[1]] & 1U) << 1U | (sides_[cell[2]] & 1U) << 2U |
           (sides_[cell[3]] & 1U) << 3U;
  }

  std::span<const model::Cell> cells_;
  std::span<const std::uint8_t> sides_;
  Cut cut_;
  PointNumbers numbers_;
};

/// The cut of all these cells.
Cut cutOf(std::span<const model::Cell> cells, std::span<const std::uint8_t> sides);

}  // namespace t4d::slice
