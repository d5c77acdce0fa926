#include "edit/split_cells.h"

#include <algorithm>

#include <Eigen/LU>
#include <fmt/format.h>

#include "formats/mesh4d/polyhedron.h"

namespace t4d::edit {

using model::Cell;
using model::Point4;

model::TimeSpan timesOf(std::span<const Point4> vertices, const Cell& cell) {
  model::TimeSpan span{vertices[cell[0]][3], vertices[cell[0]][3]};
  for (const std::uint32_t corner : cell) {
    span.begin = std::min(span.begin, vertices[corner][3]);
    span.end = std::max(span.end, vertices[corner][3]);
  }
  return span;
}

Result<void> checkNoTwins(std::span<const Cell> cells,
                          const std::function<bool(const Cell&)>& isSplit) {
  std::vector<Cell> split;
  std::ranges::copy_if(cells, std::back_inserter(split), isSplit);
  for (Cell& cell : split) std::ranges::sort(cell);
  std::ranges::sort(split);
  const auto twin = std::ranges::adjacent_find(split);
  if (twin == split.end()) return {};
  return invalid(
      fmt::format("two tetrahedra have the same corners, the vertices {} {} {} {}: they "
                  "cannot be split at a time; remove them",
                  (*twin)[0], (*twin)[1], (*twin)[2], (*twin)[3]));
}

void CellSplitter::split(const Cell& cell, double time, std::vector<Cell>& before,
                         std::vector<Cell>& after) {
  std::array<int, 4> side{};
  for (int i = 0; i < 4; ++i) {
    const double t = vertices_[cell[i]][3];
    side[i] = t < time ? -1 : t > time ? 1 : 0;
  }
  place_.clear();
  for (int i = 0; i < 4; ++i) place_.push_back({cell[i], Point4::Unit(i)});
  splitPart(cell, side, -1, time, before);
  splitPart(cell, side, 1, time, after);
}

model::Attribute CellSplitter::withNewRows(model::Attribute attribute) const {
  const std::size_t bytes = attribute.rowBytes();
  const std::size_t before = attribute.values.size();
  attribute.values.resize(before + cutEdges_.size() * bytes);
  std::byte* row = attribute.values.data() + before;
  for (const auto& [from, to, fraction] : cutEdges_) {
    // A cut edge may end at a vertex that is new itself.
    interpolateRow(attribute, from, to, fraction, row);
    row += bytes;
  }
  return attribute;
}

std::uint32_t CellSplitter::add(const CutEdge& edge) {
  const Point4& from = vertices_[edge.from];
  const Point4& to = vertices_[edge.to];
  const Point4 vertex = from + edge.fraction * (to - from);
  vertices_.push_back(vertex);
  cutEdges_.push_back(edge);
  return static_cast<std::uint32_t>(vertices_.size() - 1);
}

void CellSplitter::splitPart(const Cell& cell, const std::array<int, 4>& side, int which,
                             double time, std::vector<Cell>& into) {
  // The four triangles of the cell, clipped, and the section.
  std::array<std::vector<std::uint32_t>, 5> faces;
  for (int opposite = 0; opposite < 4; ++opposite) {
    std::array<int, 3> corners{};
    for (int i = 0, k = 0; i < 4; ++i) {
      if (i != opposite) corners[k++] = i;
    }
    auto& face = faces[opposite];
    for (int k = 0; k < 3; ++k) {
      const int a = corners[k];
      const int b = corners[(k + 1) % 3];
      if (side[a] == which || side[a] == 0) face.push_back(cell[a]);
      if (side[a] * side[b] < 0) face.push_back(cutVertex(cell, a, b, time));
    }
  }
  faces[4] = section(cell, side, time);
  std::vector<std::span<const std::uint32_t>> solid;
  for (const auto& face : faces) {
    if (face.size() >= 3) solid.emplace_back(face);
  }
  formats::pullPolyhedron(solid, [&](Cell part) {
    Eigen::Matrix4d weights;
    for (int i = 0; i < 4; ++i) {
      weights.row(i) = std::ranges::find(place_, part[i], &Place::vertex)->weights;
    }
    if (weights.determinant() < 0) std::swap(part[2], part[3]);
    into.push_back(part);
  });
}

/// The corners of the section in order around it.
std::vector<std::uint32_t> CellSplitter::section(const Cell& cell, const std::array<int, 4>& side,
                                                 double time) {
  std::vector<int> below;
  std::vector<int> above;
  std::vector<std::uint32_t> corners;
  for (int i = 0; i < 4; ++i) {
    if (side[i] < 0) below.push_back(i);
    if (side[i] > 0) above.push_back(i);
    if (side[i] == 0) corners.push_back(cell[i]);
  }
  for (std::size_t i = 0; i < below.size(); ++i) {
    for (std::size_t j = 0; j < above.size(); ++j) {
      // If two are on each side, the second row goes backwards.
      const std::size_t k = i % 2 == 0 ? j : above.size() - 1 - j;
      corners.push_back(cutVertex(cell, below[i], above[k], time));
    }
  }
  return corners;
}

std::uint32_t CellSplitter::cutVertex(const Cell& cell, int a, int b, double time) {
  if (cell[a] > cell[b]) std::swap(a, b);
  const std::uint64_t edge = std::uint64_t{cell[a]} << 32 | cell[b];
  const auto [found, isNew] =
      cutVertices_.try_emplace(edge, static_cast<std::uint32_t>(vertices_.size()));
  if (isNew) {
    const Point4& from = vertices_[cell[a]];
    const Point4& to = vertices_[cell[b]];
    const double fraction = (time - from[3]) / (to[3] - from[3]);
    Point4 vertex = from + fraction * (to - from);
    vertex[3] = time;
    vertices_.push_back(vertex);
    cutEdges_.push_back({cell[a], cell[b], fraction});
  }
  const std::uint32_t vertex = found->second;
  if (std::ranges::find(place_, vertex, &Place::vertex) == place_.end()) {
    place_.push_back({vertex, (Point4::Unit(a) + Point4::Unit(b)) / 2});
  }
  return vertex;
}

}  // namespace t4d::edit
