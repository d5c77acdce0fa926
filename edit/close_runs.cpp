#include <algorithm>
#include <array>
#include <tuple>
#include <unordered_map>

#include <fmt/format.h>

#include "model/cone.h"
#include "model/facets.h"
#include "model/union_find.h"
#include "t4d/edit.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Cell;
using model::Connectivity;
using model::Domain;
using model::Facet;
using model::Point3;
using model::Point4;
using model::Slab;

/// The facets of a layer that belong to a single cell.
std::vector<Facet> openFacets(const Connectivity& connectivity, bool lower) {
  auto topology = facetTopology(connectivity);
  std::vector<Facet>& facets = lower ? topology.lower : topology.upper;
  std::erase_if(facets, [](const Facet& facet) { return facet.isMatched(); });
  return std::move(facets);
}

/// Facets as a surface, with the connected part that each belongs to.
struct Surface {
  std::vector<std::uint32_t> part;  ///< per facet
  std::uint32_t parts = 0;
  /// The fan of facets around each corner: several of one part may have a vertex.
  std::vector<std::array<std::uint32_t, 3>> fan = {};  ///< per facet
  std::uint32_t fans = 0;
  std::vector<bool> touchesItself = {};  ///< per part
};

/// Fails if the facets are not a closed, oriented surface, and names the facet or edge at fault.
Result<Surface> surfaceOf(const std::vector<Facet>& facets) {
  struct Edge {
    std::uint32_t low, high, facet;
    bool forward;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * facets.size());
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    const auto& [a, b, c] = facets[i].vertices;
    if (facets[i].even + facets[i].odd != 1) {
      return invalid(fmt::format("the facet of its vertices {}, {} and {} has {} cells", a, b, c,
                                 facets[i].even + facets[i].odd));
    }
    const bool even = facets[i].even == 1;
    edges.push_back({a, b, i, even});
    edges.push_back({b, c, i, even});
    edges.push_back({a, c, i, !even});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.facet) < std::tie(b.low, b.high, b.facet);
  });
  // Facets that share an edge are in the same part; its root is its first facet.
  model::UnionFind parts(facets.size());
  model::UnionFind corners(3 * facets.size());
  const auto cornerOf = [&](std::uint32_t facet, std::uint32_t vertex) {
    const auto& vertices = facets[facet].vertices;
    return static_cast<std::uint32_t>(3 * facet +
                                      (std::ranges::find(vertices, vertex) - vertices.begin()));
  };
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].low == edges[i].low &&
           edges[end].high == edges[i].high) {
      ++end;
    }
    if (end - i != 2 || edges[i].forward == edges[i + 1].forward) {
      return invalid(fmt::format("the edge of its vertices {} and {} has {} open facets{}",
                                 edges[i].low, edges[i].high, end - i,
                                 end - i == 2 ? " that face opposite ways" : ""));
    }
    parts.unite(edges[i].facet, edges[i + 1].facet);
    for (const std::uint32_t vertex : {edges[i].low, edges[i].high}) {
      corners.unite(cornerOf(edges[i].facet, vertex), cornerOf(edges[i + 1].facet, vertex));
    }
    i = end;
  }
  Surface surface;
  surface.part.resize(facets.size());
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    const std::uint32_t root = parts.root(i);
    surface.part[i] = root == i ? surface.parts++ : surface.part[root];
  }
  surface.fan.resize(facets.size());
  surface.touchesItself.resize(surface.parts);
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>>
      partsAround;                   // of each fan but the first
  std::vector<std::uint32_t> first;  // part, by vertex
  for (std::uint32_t corner = 0; corner < 3 * facets.size(); ++corner) {
    const std::uint32_t facet = corner / 3;
    const std::uint32_t root = corners.root(corner);
    std::uint32_t& fan = surface.fan[facet][corner % 3];
    if (root != corner) {
      fan = surface.fan[root / 3][root % 3];
      continue;
    }
    fan = surface.fans++;
    const std::uint32_t vertex = facets[facet].vertices[corner % 3];
    const std::uint32_t part = surface.part[facet];
    if (vertex >= first.size()) first.resize(vertex + 1, model::kNoIndex);
    if (first[vertex] == model::kNoIndex) {
      first[vertex] = part;
      continue;
    }
    std::vector<std::uint32_t>& others = partsAround[vertex];
    if (first[vertex] == part || std::ranges::find(others, part) != others.end()) {
      surface.touchesItself[part] = true;
    }
    others.push_back(part);
  }
  return surface;
}

/// The row of `attribute` for every cell of a cap, if its meaning is registered.
std::optional<std::vector<std::byte>> capCellRow(const Attribute& attribute, bool begin) {
  if (attribute.components != 1) return std::nullopt;
  if (attribute.name == "kind" && attribute.type == model::ScalarType::UInt8) {
    return std::vector{std::byte{begin ? std::uint8_t{1} : std::uint8_t{2}}};
  }
  if (attribute.name == "triangle" && attribute.type == model::ScalarType::UInt32) {
    return std::vector(4, std::byte{0xFF});
  }
  return std::nullopt;
}

/// The cone over open facets of a layer of `neighbour`; only the layer if there are none. Where a
/// part of the surface touches itself at a vertex, a cone over it would have an edge to the apex
/// with cells from both sides. It begins with a layer of prisms then, up to a surface halfway to
/// the apex in which each fan has a vertex of its own.
class Cone {
 public:
  Cone(const Slab& neighbour, bool begin, const std::vector<Facet>& facets, const Surface& surface)
      : neighbour_(neighbour),
        begin_(begin),
        facets_(facets),
        surface_(surface),
        layer_(begin ? neighbour.lowerLayer() : neighbour.upperLayer()),
        layerCount_(static_cast<std::uint32_t>(layer_.size())),
        firstInNeighbour_(begin ? 0 : neighbour.connectivity->firstUpper()) {
    addApexes();
    addCells();
  }

  std::uint64_t cellCount() const { return cells_.size(); }

  Slab slab() const {
    auto connectivity = std::make_shared<Connectivity>();
    const auto added = static_cast<std::uint32_t>(added_.size());
    connectivity->vertexCount = layerCount_ + added;
    (begin_ ? connectivity->upperCount : connectivity->lowerCount) = layerCount_;
    connectivity->cells = cells_;
    for (const Attribute& attribute : neighbour_.connectivity->cellAttributes) {
      connectivity->cellAttributes.push_back(ofCells(attribute));
    }
    Slab slab;
    slab.timeBegin = slab.timeEnd = begin_ ? neighbour_.timeBegin : neighbour_.timeEnd;
    slab.vertices.assign(layer_.begin(), layer_.end());
    slab.vertices.insert(begin_ ? slab.vertices.begin() : slab.vertices.end(), added_.begin(),
                         added_.end());
    slab.connectivity = std::move(connectivity);
    for (const Attribute& attribute : neighbour_.attributes) {
      slab.attributes.push_back(attribute.domain == Domain::Cell ? ofCells(attribute)
                                                                 : ofVertices(attribute));
    }
    return slab;
  }

 private:
  /// One apex per part of the surface.
  void addApexes() {
    std::vector<model::Bounds3> bounds(surface_.parts);
    rowOfAdded_.resize(surface_.parts);
    for (std::size_t i = facets_.size(); i-- > 0;) {
      for (const std::uint32_t vertex : facets_[i].vertices) {
        bounds[surface_.part[i]].add(layer_[vertex].head<3>());
      }
      rowOfAdded_[surface_.part[i]] = facets_[i].vertices[0];
    }
    for (const model::Bounds3& part : bounds) {
      const Point3 apex = model::coneApex(part, 0.5);
      added_.emplace_back(apex.x(), apex.y(), apex.z(), layer_.front()[3]);
    }
  }

  /// Each lies on the opposite side of its facet from the existing cell.
  void addCells() {
    // Added vertices come before an upper layer, but after a lower one.
    std::vector<std::uint32_t> innerOfFan(surface_.fans, model::kNoIndex);
    std::vector<std::array<std::uint32_t, 3>> inner(facets_.size());
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      if (!surface_.touchesItself[surface_.part[i]]) continue;
      for (int k = 0; k < 3; ++k) {
        std::uint32_t& number = innerOfFan[surface_.fan[i][k]];
        if (number == model::kNoIndex) {
          number = static_cast<std::uint32_t>(added_.size());
          const std::uint32_t vertex = facets_[i].vertices[k];
          added_.push_back((layer_[vertex] + added_[surface_.part[i]]) / 2);
          added_.back()[3] = layer_.front()[3];
          rowOfAdded_.push_back(vertex);
        }
        inner[i][k] = number;
      }
    }
    const auto added = static_cast<std::uint32_t>(added_.size());
    const std::uint32_t firstInLayer = begin_ ? added : 0;
    const std::uint32_t firstAdded = begin_ ? 0 : layerCount_;
    cells_.reserve(facets_.size());
    for (std::uint32_t i = 0; i < facets_.size(); ++i) {
      const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        if (facets_[i].odd == 1) std::swap(a, b);
        cells_.push_back({a, b, c, d});
        facetOf_.push_back(i);
      };
      const auto layer = [&](int k) { return firstInLayer + facets_[i].vertices[k]; };
      const auto within = [&](int k) { return firstAdded + inner[i][k]; };
      const std::uint32_t apex = firstAdded + surface_.part[i];
      if (!surface_.touchesItself[surface_.part[i]]) {
        add(layer(0), layer(1), layer(2), apex);
        continue;
      }
      // Diagonals go inward from the lower number, on both sides of an edge.
      add(layer(0), layer(1), layer(2), within(2));
      add(layer(0), layer(1), within(2), within(1));
      add(layer(0), within(0), within(1), within(2));
      add(within(0), within(1), within(2), apex);
    }
  }

  Attribute ofCells(const Attribute& attribute) const {
    Attribute made{attribute.name, Domain::Cell, attribute.type, attribute.components, {}};
    const std::size_t bytes = attribute.rowBytes();
    made.values.reserve(cells_.size() * bytes);
    const auto agreed = capCellRow(attribute, begin_);
    for (const std::uint32_t facet : facetOf_) {
      const std::byte* row = agreed ? agreed->data() : attribute.row(facets_[facet].cell);
      made.values.insert(made.values.end(), row, row + bytes);
    }
    return made;
  }

  Attribute ofVertices(const Attribute& attribute) const {
    Attribute made{attribute.name, Domain::Vertex, attribute.type, attribute.components, {}};
    const std::size_t bytes = attribute.rowBytes();
    const std::byte* rows = attribute.row(firstInNeighbour_);
    const auto putAdded = [&] {
      for (const std::uint32_t vertex : rowOfAdded_) {
        made.values.insert(made.values.end(), rows + vertex * bytes, rows + (vertex + 1) * bytes);
      }
    };
    if (begin_) putAdded();
    made.values.insert(made.values.end(), rows, rows + layerCount_ * bytes);
    if (!begin_) putAdded();
    return made;
  }

  const Slab& neighbour_;
  bool begin_;
  const std::vector<Facet>& facets_;
  const Surface& surface_;
  std::span<const Point4> layer_;
  std::uint32_t layerCount_;
  std::uint32_t firstInNeighbour_;
  std::vector<Point4> added_;              // apexes of parts, then vertices within
  std::vector<std::uint32_t> rowOfAdded_;  // a vertex of the layer with its attributes
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> facetOf_;  // for each cell
};

bool shareLayer(const Slab& before, const Slab& after) {
  const model::Connectivity& lower = *before.connectivity;
  return std::ranges::equal(before.upperLayer(), after.lowerLayer()) &&
         vertexRows(before.attributes, lower.firstUpper(), lower.upperCount) ==
             vertexRows(after.attributes, 0, after.connectivity->lowerCount);
}

}  // namespace

Result<void> RunCloser::put(const Slab& slab) {
  if (!last_ || !shareLayer(*last_, slab)) {
    if (auto ended = endRun(true); !ended) return ended;
    if (auto begun = beginRun(slab); !begun) return begun;
  }
  if (auto put = sink_.put(slab); !put) return put;
  last_ = slab;
  ++count_;
  return {};
}

Result<std::vector<RunEnd>> RunCloser::finish() {
  if (auto ended = endRun(false); !ended) return ended.error();
  return std::move(ends_);
}

Result<void> RunCloser::beginRun(const Slab& slab) {
  if (slab.connectivity->lowerCount == 0) return {};
  return putCap(slab, true, last_.has_value());
}

Result<void> RunCloser::endRun(bool another) {
  if (!last_ || last_->connectivity->upperCount == 0) return {};
  return putCap(*last_, false, another);
}

/// With `needed`, between two runs, the slab is put even if no facet is open: consecutive slabs
/// must share a layer, so one run has to end and the next to begin with an empty one.
Result<void> RunCloser::putCap(const Slab& neighbour, bool begin, bool needed) {
  std::vector<Facet> facets = openFacets(*neighbour.connectivity, begin);
  RunEnd end;
  end.slab = begin ? count_ : count_ - 1;
  end.time = begin ? neighbour.timeBegin : neighbour.timeEnd;
  end.begin = begin;
  auto surface = surfaceOf(facets);
  if (!surface) {
    end.open = surface.error().message;
    facets.clear();
    surface = Surface{};
  }
  if (facets.empty() && !needed) {
    if (end.open) ends_.push_back(end);
    return {};
  }
  const Cone cone(neighbour, begin, facets, *surface);
  end.triangles = facets.size();
  end.cells = cone.cellCount();
  if (end.open || !facets.empty()) ends_.push_back(end);
  return sink_.put(cone.slab());
}

}  // namespace t4d::edit
