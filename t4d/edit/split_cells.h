#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "t4d/model/slab.h"

namespace t4d::edit {

/// The first and the last time of a cell's corners.
model::TimeSpan timesOf(std::span<const model::Point4> vertices, const model::Cell& cell);

/// Fails if two of the cells that `isSplit` have the same corners. Such a pair is closed, but where
/// both are split their sections coincide, with four tetrahedra at each triangle.
Result<void> checkNoTwins(std::span<const model::Cell> cells,
                          const std::function<bool(const model::Cell&)>& isSplit);

/// Splits cells at times such that neighbours agree: an edge that crosses the time gets one vertex,
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

  /// Appends the parts of a cell before and after a time that it reaches over. They face the same
  /// way as the cell.
  void split(const model::Cell& cell, double time, std::vector<model::Cell>& before,
             std::vector<model::Cell>& after);

  /// One for each new vertex, in their order.
  std::span<const CutEdge> cutEdges() const { return cutEdges_; }
  /// An attribute of the vertices given, with rows for the new ones.
  model::Attribute withNewRows(model::Attribute attribute) const;

 private:
  void splitPart(const model::Cell& cell, const std::array<int, 4>& side, int which, double time,
                 std::vector<model::Cell>& into);
  std::vector<std::uint32_t> section(const model::Cell& cell, const std::array<int, 4>& side,
                                     double time);
  std::uint32_t cutVertex(const model::Cell& cell, int a, int b, double time);

  /// A vertex of the parts, by its barycentric coordinates in the cell. Those of a new vertex are
  /// taken as half and half: which way round a part's tetrahedra are does not depend on where on
  /// its edge it lies.
  struct Place {
    std::uint32_t vertex;
    model::Point4 weights;
  };

  std::vector<model::Point4>& vertices_;
  std::unordered_map<std::uint64_t, std::uint32_t> cutVertices_;  // by edge
  std::vector<CutEdge> cutEdges_;
  std::vector<Place> place_;  // of the cell at hand
};

}  // namespace t4d::edit
