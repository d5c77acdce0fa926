#include "edit/cell_complex.h"

#include <algorithm>

namespace t4d::edit {
namespace {

using model::Cell;
using Edge = std::array<std::uint32_t, 2>;

Edge sorted(std::uint32_t p, std::uint32_t q) { return p < q ? Edge{p, q} : Edge{q, p}; }

bool isAmong(const std::vector<Edge>& edges, const Edge& edge) {
  return std::ranges::find(edges, edge) != edges.end();
}

}  // namespace

CellComplex::CellComplex(std::span<const Cell> cells, std::uint32_t vertexCount)
    : cells_(cells.begin(), cells.end()),
      next_(4 * cells.size()),
      first_(vertexCount, model::kNoIndex),
      liveCells_(static_cast<std::uint32_t>(cells.size())),
      marks_(vertexCount, 0) {
  for (std::size_t corner = next_.size(); corner-- > 0;) {
    std::uint32_t& first = first_[cells_[corner / 4][corner % 4]];
    next_[corner] = first;
    first = static_cast<std::uint32_t>(corner);
  }
}

std::span<const std::uint32_t> CellComplex::neighbours(std::uint32_t vertex) const {
  neighbours_.clear();
  const std::uint64_t mark = newMark();
  marks_[vertex] = mark;
  eachCell(vertex, [&](std::uint32_t cell, int) {
    for (const std::uint32_t corner : cells_[cell]) {
      if (marks_[corner] == mark) continue;
      marks_[corner] = mark;
      neighbours_.push_back(corner);
    }
  });
  return neighbours_;
}

bool CellComplex::canCollapse(std::uint32_t a, std::uint32_t b) const {
  // The link of the edge: a ring of vertices and edges, one edge for each cell with a and b.
  ring_.clear();
  eachCell(a, [&](std::uint32_t cell, int) {
    if (!hasCorner(cells_[cell], b)) return;
    Edge edge{model::kNoIndex, model::kNoIndex};
    for (const std::uint32_t corner : cells_[cell]) {
      if (corner != a && corner != b) edge[edge[0] == model::kNoIndex ? 0 : 1] = corner;
    }
    ring_.push_back(sorted(edge[0], edge[1]));
  });
  if (ring_.size() < 3) return false;

  // No vertex outside the ring is a neighbour of both.
  neighbours(a);
  const std::uint64_t nextToA = mark_;
  const std::uint64_t onRing = newMark();
  std::size_t ringVertices = 0;
  for (const Edge& edge : ring_) {
    for (const std::uint32_t vertex : edge) {
      ringVertices += marks_[vertex] != onRing ? 1 : 0;
      marks_[vertex] = onRing;
    }
  }
  if (ringVertices != ring_.size()) return false;
  bool meetsElsewhere = false;
  eachCell(b, [&](std::uint32_t cell, int) {
    for (const std::uint32_t corner : cells_[cell]) {
      meetsElsewhere |= corner != b && corner != a && marks_[corner] == nextToA;
    }
  });
  if (meetsElsewhere) return false;

  // No edge between vertices of the ring, but its own, belongs to both links; nor a triangle.
  chords_.clear();
  bool triangleOfA = false;
  bool isFree = true;
  const auto visitLink = [&](std::uint32_t centre, std::uint32_t other, auto visitEdge,
                             auto visitTriangle) {
    eachCell(centre, [&](std::uint32_t cell, int k) {
      const Cell& corners = cells_[cell];
      if (hasCorner(corners, other)) return;
      int inRing = 0;
      for (int i = 0; i < 4; ++i) {
        if (i == k || marks_[corners[i]] != onRing) continue;
        ++inRing;
        for (int j = 0; j < i; ++j) {
          if (j == k || marks_[corners[j]] != onRing) continue;
          const Edge edge = sorted(corners[i], corners[j]);
          if (!isAmong(ring_, edge)) visitEdge(edge);
        }
      }
      if (inRing == 3) visitTriangle();
    });
  };
  visitLink(
      a, b, [&](const Edge& edge) { chords_.push_back(edge); }, [&] { triangleOfA = true; });
  visitLink(
      b, a, [&](const Edge& edge) { isFree &= !isAmong(chords_, edge); },
      [&] { isFree &= !(triangleOfA && ring_.size() == 3); });
  return isFree;
}

void CellComplex::dropDeadCorners(std::uint32_t vertex) {
  std::uint32_t* link = &first_[vertex];
  while (*link != model::kNoIndex) {
    if (isDead(*link / 4)) {
      *link = next_[*link];
    } else {
      link = &next_[*link];
    }
  }
}

void CellComplex::collapse(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t mark = newMark();
  marks_[a] = mark;
  marks_[b] = mark;
  neighbours_.clear();
  eachCell(b, [&](std::uint32_t cell, int k) {
    Cell& corners = cells_[cell];
    if (!hasCorner(corners, a)) {
      corners[k] = a;
      return;
    }
    for (const std::uint32_t corner : corners) {
      if (marks_[corner] == mark) continue;
      marks_[corner] = mark;
      neighbours_.push_back(corner);
    }
    corners[0] = model::kNoIndex;
    --liveCells_;
  });
  for (const std::uint32_t vertex : neighbours_) dropDeadCorners(vertex);
  dropDeadCorners(a);
  dropDeadCorners(b);
  std::uint32_t* last = &first_[a];
  while (*last != model::kNoIndex) last = &next_[*last];
  *last = first_[b];
  first_[b] = model::kNoIndex;
}

}  // namespace t4d::edit
