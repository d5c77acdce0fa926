#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

/// The first and the last time of a cell's corners.
model::TimeSpan timesOf(std::span<const model::Point4> vertices, const model::Cell& cell);

/// Fails if two cells with `isSplit` have the same corners. Such a pair is closed, but if both
/// cells are split, their sections coincide, with four tetrahedra at each triangle.
Result<void> checkNoTwins(std::span<const model::Cell> cells,
                          const std::function<bool(const model::Cell&)>& isSplit);

/// Splits cells at times so that neighbours agree: an edge that crosses the time gets one vertex,
/// at exactly that time, which all its cells share; the two parts of a cell are split by pulling
/// from their first vertex (formats/mesh4d/polyhedron.h).
class CellSplitter {
 public:
  /// An edge with a new vertex: where it lies between the vertices `from` and `to`.
  struct CutEdge {
    std::uint32_t from;
    std::uint32_t to;
    double fraction;
  };

  /// New vertices are appended to `vertices`, which must outlive it.
  explicit CellSplitter(std::vector<model::Point4>& vertices) : vertices_(vertices) {}

  /// Appends the parts of a cell before and after a time that it spans. They face the same way as
  /// the cell.
  void split(const model::Cell& cell, double time, std::vector<model::Cell>& before,
             std::vector<model::Cell>& after);

  /// Adds a vertex at a place between two, or, if they are equal, another one at their place.
  std::uint32_t add(const CutEdge& edge);

  /// The edges that were cut, one for each new vertex, in order.
  std::span<const CutEdge> cutEdges() const { return cutEdges_; }
  /// An attribute of the given vertices, with rows for the new ones added.
  model::Attribute withNewRows(model::Attribute attribute) const;

 private:
  void splitPart(const model::Cell& cell, const std::array<int, 4>& side, int which, double time,
                 std::vector<model::Cell>& into);
  std::vector<std::uint32_t> section(const model::Cell& cell, const std::array<int, 4>& side,
                                     double time);
  std::uint32_t cutVertex(const model::Cell& cell, int a, int b, double time);

  /// The barycentric coordinates of a vertex of the parts in the cell. A new vertex counts as the
  /// middle of its edge, since the orientation of a part's tetrahedra does not depend on its
  /// position on the edge.
  struct Place {
    std::uint32_t vertex;
    model::Point4 weights;
  };

  std::vector<model::Point4>& vertices_;
  std::unordered_map<std::uint64_t, std::uint32_t> cutVertices_;  // by edge
  std::vector<CutEdge> cutEdges_;
  std::vector<Place> place_;  // of the current cell
};

}  // namespace t4d::edit
