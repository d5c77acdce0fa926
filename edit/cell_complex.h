#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

inline bool hasCorner(const model::Cell& cell, std::uint32_t vertex) {
  return std::ranges::find(cell, vertex) != cell.end();
}

/// The cells of a 4D mesh as a simplicial complex whose edges can be collapsed. The corners of a
/// vertex are a linked list, so that its star, the cells around it, is found quickly:
///
///     corner 4 c + k of cell c  ->  its vertex, and the next corner of that vertex
class CellComplex {
 public:
  /// The cells must pass model::checkCells.
  CellComplex(std::span<const model::Cell> cells, std::uint32_t vertexCount);

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(first_.size()); }
  std::uint32_t liveCells() const { return liveCells_; }
  std::span<const model::Cell> cells() const { return cells_; }
  bool isDead(std::uint32_t cell) const { return cells_[cell][0] == model::kNoIndex; }
  /// Whether any cell has the vertex.
  bool isUsed(std::uint32_t vertex) const { return first_[vertex] != model::kNoIndex; }

  /// Calls visit(cell, k) for each cell around a vertex, which is its corner k.
  template <class Visit>
  void eachCell(std::uint32_t vertex, Visit visit) const {
    for (std::uint32_t corner = first_[vertex]; corner != model::kNoIndex; corner = next_[corner]) {
      visit(corner / 4, static_cast<int>(corner % 4));
    }
  }

  /// The vertices that share an edge with a vertex.
  std::span<const std::uint32_t> neighbours(std::uint32_t vertex) const;

  /// Whether the mesh stays the same 3-manifold when b moves onto a: the link condition, that the
  /// links of a and b have exactly the link of the edge in common (Dey, Edelsbrunner, Guha and
  /// Nekhayev 1999). All cells around a and b must be part of the complex, and their links spheres.
  bool canCollapse(std::uint32_t a, std::uint32_t b) const;

  /// Joins b to a: removes cells with both, and replaces b by a in the other cells.
  void collapse(std::uint32_t a, std::uint32_t b);

 private:
  void dropDeadCorners(std::uint32_t vertex);
  std::uint64_t newMark() const { return ++mark_; }

  std::vector<model::Cell> cells_;  // a removed cell begins with model::kNoIndex
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> first_;
  std::uint32_t liveCells_;

  // Buffers. A vertex is marked if its entry is the present mark.
  mutable std::vector<std::uint64_t> marks_;
  mutable std::uint64_t mark_ = 0;
  mutable std::vector<std::uint32_t> neighbours_;
  mutable std::vector<std::array<std::uint32_t, 2>> ring_;
  mutable std::vector<std::array<std::uint32_t, 2>> chords_;
};

}  // namespace t4d::edit
