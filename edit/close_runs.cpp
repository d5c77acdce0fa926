#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "model/cone.h"
#include "model/facets.h"
#include "model/union_find.h"
#include "t4d/edit.h"

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
    i = end;
  }
  Surface surface;
  surface.part.resize(facets.size());
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    const std::uint32_t root = parts.root(i);
    surface.part[i] = root == i ? surface.parts++ : surface.part[root];
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

/// The cone over open facets of a layer of `neighbour`; only the layer if there are none.
class Cone {
 public:
  Cone(const Slab& neighbour, bool begin, const std::vector<Facet>& facets, const Surface& surface)
      : neighbour_(neighbour),
        begin_(begin),
        facets_(facets),
        surface_(surface),
        layer_(begin ? neighbour.lowerLayer() : neighbour.upperLayer()),
        layerCount_(static_cast<std::uint32_t>(layer_.size())),
        firstInNeighbour_(begin ? 0 : neighbour.connectivity->firstUpper()) {}

  Slab slab() const {
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->vertexCount = layerCount_ + surface_.parts;
    (begin_ ? connectivity->upperCount : connectivity->lowerCount) = layerCount_;
    connectivity->cells = cells();
    for (const Attribute& attribute : neighbour_.connectivity->cellAttributes) {
      connectivity->cellAttributes.push_back(ofCells(attribute));
    }
    Slab slab;
    slab.timeBegin = slab.timeEnd = begin_ ? neighbour_.timeBegin : neighbour_.timeEnd;
    const std::vector<Point4> apexes = this->apexes();
    slab.vertices.assign(layer_.begin(), layer_.end());
    slab.vertices.insert(begin_ ? slab.vertices.begin() : slab.vertices.end(), apexes.begin(),
                         apexes.end());
    slab.connectivity = std::move(connectivity);
    for (const Attribute& attribute : neighbour_.attributes) {
      slab.attributes.push_back(attribute.domain == Domain::Cell ? ofCells(attribute)
                                                                 : ofVertices(attribute));
    }
    return slab;
  }

 private:
  /// Each lies on the opposite side of its facet from the existing cell.
  std::vector<Cell> cells() const {
    // Apexes come before an upper layer, but after a lower one.
    const std::uint32_t firstInLayer = begin_ ? surface_.parts : 0;
    const std::uint32_t firstApex = begin_ ? 0 : layerCount_;
    std::vector<Cell> cells;
    cells.reserve(facets_.size());
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      auto [a, b, c] = facets_[i].vertices;
      if (facets_[i].odd == 1) std::swap(a, b);
      cells.push_back(
          {firstInLayer + a, firstInLayer + b, firstInLayer + c, firstApex + surface_.part[i]});
    }
    return cells;
  }

  /// One apex per part of the surface.
  std::vector<Point4> apexes() const {
    std::vector<model::Bounds3> bounds(surface_.parts);
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      for (const std::uint32_t vertex : facets_[i].vertices) {
        bounds[surface_.part[i]].add(layer_[vertex].head<3>());
      }
    }
    std::vector<Point4> apexes;
    for (const model::Bounds3& part : bounds) {
      const Point3 apex = model::coneApex(part, 0.5);
      apexes.emplace_back(apex.x(), apex.y(), apex.z(), layer_.front()[3]);
    }
    return apexes;
  }

  Attribute ofCells(const Attribute& attribute) const {
    Attribute made{attribute.name, Domain::Cell, attribute.type, attribute.components, {}};
    const std::size_t bytes = attribute.rowBytes();
    made.values.reserve(facets_.size() * bytes);
    const auto agreed = capCellRow(attribute, begin_);
    for (const Facet& facet : facets_) {
      const std::byte* row = agreed ? agreed->data() : attribute.row(facet.cell);
      made.values.insert(made.values.end(), row, row + bytes);
    }
    return made;
  }

  Attribute ofVertices(const Attribute& attribute) const {
    Attribute made{attribute.name, Domain::Vertex, attribute.type, attribute.components, {}};
    const std::size_t bytes = attribute.rowBytes();
    const std::byte* rows = attribute.row(firstInNeighbour_);
    std::vector<const std::byte*> ofApex(surface_.parts);
    for (std::size_t i = facets_.size(); i-- > 0;) {
      ofApex[surface_.part[i]] = rows + facets_[i].vertices[0] * bytes;
    }
    const auto putApexes = [&] {
      for (const std::byte* row : ofApex) made.values.insert(made.values.end(), row, row + bytes);
    };
    if (begin_) putApexes();
    made.values.insert(made.values.end(), rows, rows + layerCount_ * bytes);
    if (!begin_) putApexes();
    return made;
  }

  const Slab& neighbour_;
  bool begin_;
  const std::vector<Facet>& facets_;
  const Surface& surface_;
  std::span<const Point4> layer_;
  std::uint32_t layerCount_;
  std::uint32_t firstInNeighbour_;
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
  end.triangles = facets.size();
  if (end.open || !facets.empty()) ends_.push_back(end);
  if (facets.empty() && !needed) return {};
  return sink_.put(Cone(neighbour, begin, facets, *surface).slab());
}

}  // namespace t4d::edit
