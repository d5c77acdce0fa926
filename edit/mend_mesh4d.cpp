#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/LU>
#include <fmt/format.h>

#include "measure/slab_measure.h"
#include "model/attribute_rows.h"
#include "model/facets.h"
#include "model/parallel.h"
#include "model/union_find.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;
using model::Cell;
using model::Facet;
using model::Point4;

std::vector<Facet> unmatchedFacets(Mesh4d& mesh) {
  model::Connectivity connectivity;
  connectivity.vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  connectivity.cells = std::move(mesh.cells);
  const model::FacetParts parts(connectivity);
  std::vector<std::vector<Facet>> found(parts.size());
  model::forEach(parts.size(), [&](std::size_t i) { found[i] = parts.topology(i).unmatched; });
  std::vector<Facet> unmatched;
  for (const auto& some : found) unmatched.insert(unmatched.end(), some.begin(), some.end());
  mesh.cells = std::move(connectivity.cells);
  return unmatched;
}

bool isOpen(const std::vector<Facet>& unmatched) {
  return !std::ranges::all_of(unmatched, &Facet::isClosed);
}

/// Merges vertices within `tolerance` of each other along each axis, through chains of such pairs,
/// into the first of them. Returns how many were merged.
std::size_t weld(Mesh4d& mesh, double tolerance) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  const auto& vertices = mesh.vertices;
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (vertices[a][0] != vertices[b][0]) return vertices[a][0] < vertices[b][0];
    if (tolerance > 0) return a < b;
    const auto* pa = vertices[a].data();
    const auto* pb = vertices[b].data();
    if (const auto compared = std::lexicographical_compare_three_way(pa, pa + 4, pb, pb + 4);
        compared != 0) {
      return compared < 0;
    }
    return a < b;
  });
  model::UnionFind sets(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const Point4 apart = (vertices[order[j]] - vertices[order[i]]).cwiseAbs();
      if (apart[0] > tolerance) break;
      if (apart.maxCoeff() <= tolerance) {
        sets.unite(order[i], order[j]);
      } else if (tolerance == 0) {
        break;  // equal vertices are next to each other
      }
    }
  }
  std::vector<std::uint32_t> number(count);
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t root = sets.root(i);  // not above i
    number[i] = root == i ? static_cast<std::uint32_t>(kept.size()) : number[root];
    if (root != i) continue;
    mesh.vertices[number[i]] = mesh.vertices[i];
    kept.push_back(i);
  }
  mesh.vertices.resize(kept.size());
  if (kept.size() < count) selectRows(mesh.attributes, model::Domain::Vertex, kept);
  for (Cell& cell : mesh.cells) {
    for (std::uint32_t& corner : cell) corner = number[corner];
  }
  return count - kept.size();
}

/// Removes cells with two equal corners. Returns how many.
std::size_t dropCollapsed(Mesh4d& mesh) {
  const auto collapsed = [](Cell cell) {
    std::ranges::sort(cell);
    return std::ranges::adjacent_find(cell) != cell.end();
  };
  if (!mesh.attributes.empty()) {
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < mesh.cells.size(); ++i) {
      if (!collapsed(mesh.cells[i])) kept.push_back(i);
    }
    selectRows(mesh.attributes, model::Domain::Cell, kept);
  }
  return std::erase_if(mesh.cells, collapsed);
}

void turn(Cell& cell) { std::swap(cell[2], cell[3]); }

/// A facet of a cell, by the number 4 * cell + corner of the corner opposite.
struct Side {
  std::array<std::uint32_t, 3> vertices;
  std::uint32_t number;
  bool even;
};

/// Turns cells until neighbours agree, and each connected part encloses a positive hypervolume.
/// Returns how many were turned; nothing if there is no such way, and then changes nothing.
std::optional<std::size_t> orient(Mesh4d& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * mesh.cells.size());
  for (std::uint32_t cell = 0; cell < mesh.cells.size(); ++cell) {
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const auto [vertices, even] =
          model::facetOpposite(mesh.cells[cell], static_cast<int>(corner));
      sides.push_back({vertices, 4 * cell + corner, even});
    }
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::tie(a.vertices, a.number) < std::tie(b.vertices, b.number);
  });
  struct Neighbour {
    std::uint32_t cell = model::kNoIndex;
    bool agrees = false;
  };
  std::vector<Neighbour> neighbours(4 * mesh.cells.size());
  for (auto at = sides.begin(); at != sides.end();) {
    const auto end = std::find_if(at, sides.end(),
                                  [&](const Side& side) { return side.vertices != at->vertices; });
    if (end - at == 2) {
      const bool agree = at[0].even != at[1].even;
      neighbours[at[0].number] = {at[1].number / 4, agree};
      neighbours[at[1].number] = {at[0].number / 4, agree};
    }
    at = end;
  }
  enum class State : char { Unseen, Kept, Turned };
  std::vector<State> state(mesh.cells.size(), State::Unseen);
  std::vector<std::uint32_t> part;
  std::vector<Cell> partCells;
  std::size_t turned = 0;
  std::vector<Cell> result = mesh.cells;
  for (std::uint32_t seed = 0; seed < mesh.cells.size(); ++seed) {
    if (state[seed] != State::Unseen) continue;
    part = {seed};
    state[seed] = State::Kept;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::uint32_t cell = part[next];
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const auto [other, agrees] = neighbours[4 * std::size_t{cell} + corner];
        if (other == model::kNoIndex) continue;
        const State expected = (state[cell] == State::Kept) == agrees ? State::Kept : State::Turned;
        if (state[other] == State::Unseen) {
          state[other] = expected;
          part.push_back(other);
        } else if (state[other] != expected) {
          return std::nullopt;
        }
      }
    }
    partCells.clear();
    for (const std::uint32_t cell : part) {
      if (state[cell] == State::Turned) turn(result[cell]);
      partCells.push_back(result[cell]);
    }
    const bool inverted = measure::hypervolumeSign(mesh.vertices, partCells) < 0;
    for (const std::uint32_t cell : part) {
      if (inverted) turn(result[cell]);
      turned += (state[cell] == State::Turned) != inverted ? 1 : 0;
    }
  }
  mesh.cells = std::move(result);
  return turned;
}

std::string describe(const Mesh4d& mesh, const Facet& facet) {
  std::string text = "the triangle";
  for (const std::uint32_t vertex : facet.vertices) {
    const Point4& p = mesh.vertices[vertex];
    text += fmt::format(" ({:.6g} {:.6g} {:.6g} {:.6g})", p[0], p[1], p[2], p[3]);
  }
  return text;
}

Error notClosed(const Mesh4d& mesh, const std::vector<Facet>& unmatched) {
  const auto first = std::ranges::find_if_not(unmatched, &Facet::isClosed);
  const auto count = std::ranges::count_if(unmatched, [](const Facet& f) { return !f.isClosed(); });
  return invalid(
      fmt::format("is not closed: {} of its triangles {} not have two tetrahedra; the first, {}, "
                  "has {}",
                  count, count == 1 ? "does" : "do", describe(mesh, *first),
                  first->even + first->odd),
      {}, Remedy::OpenMesh);
}

/// A solid without content, which validation would call inside out.
Error notSolid(const Mesh4d& mesh) {
  const auto flat = std::ranges::count_if(mesh.cells, [&](const Cell& cell) {
    Eigen::Matrix<double, 4, 3> edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = mesh.vertices[cell[i + 1]] - mesh.vertices[cell[0]];
    return edges.fullPivLu().rank() < 3;
  });
  std::vector<Point4> points = mesh.vertices;
  const auto less = [](const Point4& a, const Point4& b) {
    return std::lexicographical_compare(a.data(), a.data() + 4, b.data(), b.data() + 4);
  };
  std::ranges::sort(points, less);
  const auto same = points.end() - std::unique(points.begin(), points.end());
  if (flat + same == 0) {
    return invalid("encloses no hypervolume: its parts cancel each other", {}, Remedy::OpenMesh);
  }
  return invalid(fmt::format("encloses no hypervolume: {} of its {} tetrahedra are flat, and {} of "
                             "its {} vertices lie exactly on others",
                             flat, mesh.cells.size(), same, mesh.vertices.size()),
                 {}, Remedy::OpenMesh);
}

}  // namespace

Result<Mend4dReport> mendMesh4d(Mesh4d& mesh, const Mend4dOptions& options) {
  Mend4dReport report;
  const auto weldWithin = [&](double tolerance) {
    const std::size_t merged = weld(mesh, tolerance);
    if (merged == 0) return;
    report.changes.push_back(
        tolerance > 0 ? fmt::format("merged {} vertices within {} of others", merged, tolerance)
                      : fmt::format("merged {} vertices that equal others", merged));
    if (const std::size_t collapsed = dropCollapsed(mesh)) {
      report.changes.push_back(fmt::format("dropped {} tetrahedra that this made flat", collapsed));
    }
  };
  if (options.weld) weldWithin(*options.weld);
  std::vector<Facet> unmatched = unmatchedFacets(mesh);
  if (isOpen(unmatched) && !options.weld) {
    weldWithin(0);
    if (!report.changes.empty()) unmatched = unmatchedFacets(mesh);
  }
  if (mesh.cells.empty()) return invalid("no tetrahedron is left after merging vertices");
  report.closed = !isOpen(unmatched);
  if (!report.closed && !options.allowOpen) return notClosed(mesh, unmatched);
  const auto disagrees = [](const Facet& facet) { return facet.isClosed() && !facet.isMatched(); };
  const bool wasOriented = std::ranges::none_of(unmatched, disagrees);
  report.oriented = wasOriented;
  if (!wasOriented) {
    const auto turned = orient(mesh);
    report.oriented = turned.has_value();
    if (turned) {
      if (*turned > 0) {
        report.changes.push_back(
            fmt::format("turned {} tetrahedra, so that neighbours agree", *turned));
      }
    } else if (!options.allowOpen) {
      const auto first = std::ranges::find_if(unmatched, disagrees);
      return invalid(fmt::format("cannot be oriented: it has only one side. Neighbours disagree at "
                                 "{}",
                                 describe(mesh, *first)),
                     {}, Remedy::OpenMesh);
    }
  }
  if (!report.closed || !report.oriented) return report;
  const int sign = measure::hypervolumeSign(mesh.vertices, mesh.cells);
  if (sign < 0 && wasOriented) {
    for (Cell& cell : mesh.cells) turn(cell);
    report.changes.emplace_back("turned the mesh inside out: it enclosed a negative hypervolume");
  } else if (sign <= 0) {
    if (!options.allowOpen) return notSolid(mesh);
    report.changes.emplace_back("encloses no hypervolume, so validation will call it invalid");
  }
  return report;
}

}  // namespace t4d::edit
