#include "formats/mesh4d/mesh4d_builder.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "model/attribute_rows.h"
#include "model/facets.h"
#include "model/limits.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

using model::Cell;
using model::Point4;

constexpr std::uint64_t kMostVertices = std::numeric_limits<std::uint32_t>::max();

bool hasEqualCorners(const Cell& cell) {
  const auto& [a, b, c, d] = cell;
  return a == b || a == c || a == d || b == c || b == d || c == d;
}

std::uint64_t mixed(std::uint64_t bits) {
  bits ^= bits >> 31;
  bits *= 0x7FB5D329728EA185U;
  bits ^= bits >> 27;
  bits *= 0x81DADEF4BC2DD44DU;
  return bits ^ bits >> 33;
}

/// The sum of a random number for each facet, with the sign of its orientation: 0 for cells that
/// are closed and oriented, and hardly ever otherwise. What is not oriented sums to 0 modulo 2 in
/// the other sum, without signs, as exclusive or.
struct Boundary {
  std::uint64_t oriented = 0;
  std::uint64_t unoriented = 0;

  void add(const Cell& cell) {
    for (int corner = 0; corner < 4; ++corner) {
      const auto [v, even] = model::facetOpposite(cell, corner);
      const std::uint64_t number = mixed(mixed(mixed(v[0] + std::uint64_t{1}) + v[1]) * 3 + v[2]);
      oriented += even ? number : ~number + 1;
      unoriented ^= number;
    }
  }
  bool closed() const { return oriented == 0 || unoriented == 0; }
};

}  // namespace

void Mesh4dBuilder::reserve(std::size_t vertices, std::size_t cells) {
  vertices_.reserve(vertices);
  cells_.reserve(cells);
}

Result<void> Mesh4dBuilder::addVertex(const Point4& vertex, Position position) {
  if (!vertex.allFinite()) {
    return invalid("a coordinate is not finite", placeOf_(position));
  }
  if (vertex.cwiseAbs().maxCoeff() > model::kLargestCoordinate) {
    return invalid(fmt::format("a coordinate is beyond {}: its hypervolume is too large to compute",
                               model::kLargestCoordinate),
                   placeOf_(position));
  }
  if (vertices_.size() == kMostVertices) {
    return invalid("there are more vertices than 32-bit indices can number", placeOf_(position));
  }
  vertices_.push_back(vertex);
  return {};
}

Result<void> Mesh4dBuilder::addCell(const std::array<std::uint64_t, 4>& corners, std::int64_t part,
                                    Position position) {
  Cell cell{};
  for (int i = 0; i < 4; ++i) {
    if (corners[i] >= kMostVertices) {
      return invalid(fmt::format("a tetrahedron refers to vertex {}, but there are fewer",
                                 corners[i] + firstIndex_),
                     placeOf_(position));
    }
    cell[i] = static_cast<std::uint32_t>(corners[i]);
    if (cell[i] > largestCorner_ || cells_.empty()) {
      largestCorner_ = std::max(cell[i], largestCorner_);
      positionOfLargest_ = position;
    }
  }
  if (hasEqualCorners(cell)) {
    droppedCells_.push_back(cells_.size() + droppedCells_.size());
    return {};
  }
  if (cells_.empty() && parts_.empty()) firstPart_ = part;
  if (parts_.empty() && part != firstPart_) parts_.assign(cells_.size(), firstPart_);
  cells_.push_back(cell);
  if (!parts_.empty() || part != firstPart_) parts_.push_back(part);
  return {};
}

Result<void> Mesh4dBuilder::addVertices(std::vector<Point4> vertices) {
  const bool good = std::ranges::all_of(vertices, [](const Point4& vertex) {
    // This is also false for NaN.
    return (vertex.array().abs() <= model::kLargestCoordinate).all();
  });
  if (good && vertices_.empty() && vertices.size() <= kMostVertices) {
    vertices_ = std::move(vertices);
    return {};
  }
  vertices_.reserve(vertices_.size() + vertices.size());
  for (const Point4& vertex : vertices) {
    if (auto added = addVertex(vertex, vertices_.size()); !added) return added;
  }
  return {};
}

Result<void> Mesh4dBuilder::addCells(std::vector<Cell> cells, std::size_t first,
                                     std::span<const std::int64_t> parts) {
  const bool plain = cells_.empty() && droppedCells_.empty() && first == 0 && parts.empty() &&
                     std::ranges::none_of(cells, hasEqualCorners);
  if (!plain) cells_.reserve(cells_.size() + cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto& [a, b, c, d] = cells[i];
    if (!plain) {
      const std::int64_t part = parts.empty() ? 0 : parts[i];
      auto added = addCell({first + a, first + b, first + c, first + d}, part, i);
      if (!added) return added;
    } else if (const std::uint32_t largest = std::max({a, b, c, d});
               largest > largestCorner_ || i == 0) {
      largestCorner_ = largest;
      positionOfLargest_ = i;
    }
  }
  if (plain) cells_ = std::move(cells);
  return {};
}

Result<void> Mesh4dBuilder::checkCorners() const {
  if (cells_.empty() && droppedCells_.empty()) return {};
  if (largestCorner_ < vertices_.size()) return {};
  return invalid(
      fmt::format("a tetrahedron refers to vertex {}, but there are {} vertices, "
                  "numbered from {}",
                  std::uint64_t{largestCorner_} + firstIndex_, vertices_.size(), firstIndex_),
      placeOf_(positionOfLargest_));
}

std::vector<Mesh4d> Mesh4dBuilder::split(const std::vector<std::int64_t>& parts,
                                         const std::map<std::int64_t, std::string>& names) {
  std::vector<std::uint32_t> number(vertices_.size(), model::kNoIndex);
  std::vector<Mesh4d> bodies;
  for (const std::int64_t part : parts) {
    Mesh4d body;
    if (const auto name = names.find(part); name != names.end()) body.name = name->second;
    const auto isOfPart = [&](std::size_t cell) { return parts_.empty() || parts_[cell] == part; };
    std::ranges::fill(number, model::kNoIndex);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (!isOfPart(i)) continue;
      for (const std::uint32_t corner : cells_[i]) number[corner] = 0;
    }
    std::vector<std::uint32_t> rows;
    body.attributes = attributes_;
    for (std::uint32_t i = 0; i < number.size(); ++i) {
      if (number[i] == model::kNoIndex) continue;
      number[i] = static_cast<std::uint32_t>(body.vertices.size());
      body.vertices.push_back(vertices_[i]);
      rows.push_back(i);
    }
    selectRows(body.attributes, model::Domain::Vertex, rows);
    rows.clear();
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      if (!isOfPart(i)) continue;
      Cell cell = cells_[i];
      for (std::uint32_t& corner : cell) corner = number[corner];
      body.cells.push_back(cell);
      rows.push_back(i);
    }
    selectRows(body.attributes, model::Domain::Cell, rows);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

Result<LoadedMesh4d> Mesh4dBuilder::finish(const std::map<std::int64_t, std::string>& names) && {
  if (auto good = checkCorners(); !good) return good.error();
  if (cells_.empty()) return invalid("holds no tetrahedra", file_);
  LoadedMesh4d loaded;
  if (!droppedCells_.empty()) {
    loaded.notices.push_back(fmt::format("{}: dropped {} tetrahedra with two equal corners",
                                         file_.text(), droppedCells_.size()));
    std::vector<std::uint32_t> kept;
    auto dropped = droppedCells_.begin();
    for (std::uint32_t i = 0; i < cells_.size() + droppedCells_.size(); ++i) {
      if (dropped != droppedCells_.end() && *dropped == i) {
        ++dropped;
      } else {
        kept.push_back(i);
      }
    }
    selectRows(attributes_, model::Domain::Cell, kept);
  }
  std::map<std::int64_t, Boundary> boundaries;
  for (std::size_t i = 0; i < parts_.size(); ++i) boundaries[parts_[i]].add(cells_[i]);
  std::vector<std::int64_t> parts;
  for (const auto& [part, boundary] : boundaries) parts.push_back(part);
  const bool together =
      !std::ranges::all_of(boundaries, [](const auto& entry) { return entry.second.closed(); });
  if (together) {
    loaded.notices.push_back(
        fmt::format("{}: {} groups of tetrahedra are one body: they are not closed by themselves",
                    file_.text(), parts.size()));
    parts_.clear();
    parts = {firstPart_};
  }
  if (parts.empty()) parts = {firstPart_};
  std::vector<bool> used(vertices_.size());
  for (const Cell& cell : cells_) {
    for (const std::uint32_t corner : cell) used[corner] = true;
  }
  const auto unused = std::ranges::count(used, false);
  if (unused > 0) {
    loaded.notices.push_back(
        fmt::format("{}: dropped {} vertices without tetrahedra", file_.text(), unused));
  }
  if (parts.size() == 1 && unused == 0) {
    Mesh4d body{{}, std::move(vertices_), std::move(cells_), std::move(attributes_)};
    if (const auto name = names.find(parts.front()); name != names.end() && !together) {
      body.name = name->second;
    }
    loaded.bodies.push_back(std::move(body));
  } else {
    loaded.bodies = split(parts, together ? std::map<std::int64_t, std::string>() : names);
  }
  return loaded;
}

}  // namespace t4d::formats
