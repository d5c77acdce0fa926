#include "t4d/convert/slice.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

namespace t4d::convert {
namespace {

using model::Attribute;
using model::Cell;
using model::Domain;
using model::Point4;
using model::ScalarType;
using model::Slab;
using model::Triangle;

/// The two corners of a cell with a cut point between them: one below and one above.
struct CutEdge {
  std::uint8_t below;
  std::uint8_t above;
};

/// The section of a cell for each pattern of corners above (bit i for corner i): a polygon of 0, 3
/// or 4 cut edges. With an even permutation (i, j, k, l) of the corners it is
///
///     i below:       ij, ik, il          i above:  il, ik, ij
///     i, j below:    ik, il, jl, jk
///
/// which faces outward if the cell does: for i below, moving away from corner i along the three
/// edges keeps det[n, j-i, k-i, l-i] > 0.
struct Section {
  std::uint8_t size = 0;
  std::array<CutEdge, 4> edges{};
};

std::array<Section, 16> makeSections() {
  std::array<Section, 16> sections;
  std::array<std::uint8_t, 4> p = {0, 1, 2, 3};
  do {
    int inversions = 0;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) inversions += p[a] > p[b] ? 1 : 0;
    }
    if (inversions % 2 != 0) continue;
    const auto [i, j, k, l] = p;
    const unsigned one = 1U << i;
    sections[15U ^ one] = {3, {{{i, j}, {i, k}, {i, l}, {}}}};
    sections[one] = {3, {{{l, i}, {k, i}, {j, i}, {}}}};
    sections[1U << k | 1U << l] = {4, {{{i, k}, {i, l}, {j, l}, {j, k}}}};
  } while (std::next_permutation(p.begin(), p.end()));
  return sections;
}

const std::array<Section, 16>& sections() {
  static const std::array<Section, 16> table = makeSections();
  return table;
}

constexpr std::uint32_t kNone = ~0U;

}  // namespace

/// A vertex of the slice: on the edge between two vertices of the slab, or at a single vertex (both
/// equal).
struct Slicer::CutPoint {
  std::uint32_t below;
  std::uint32_t above;
  double fraction;  // from below to above
};

/// Maps edges of the slab to vertices of the slice. Each vertex has a chain of the cut edges above
/// it, whose entries are close together in memory because the cells are. A chain that would be
/// longer than a few dozen, as at the apex of a cone, goes on in a hash table.
class Slicer::PointTable {
 public:
  /// Clears the table, for a slab with `vertexCount` vertices.
  void clear(std::size_t vertexCount) {
    first_.assign(vertexCount, kNone);
    entries_.clear();
    others_.clear();
  }

  /// The value of an edge, kNone if it is new. The caller then sets it before the next call.
  std::uint32_t& at(std::uint32_t below, std::uint32_t above) {
    std::uint32_t* link = &first_[below];
    for (int length = 0; *link != kNone; ++length) {
      Entry& entry = entries_[*link];
      if (entry.above == above) return entry.point;
      if (length == kLongestChain) {
        return others_.try_emplace(std::uint64_t{below} << 32U | above, kNone).first->second;
      }
      link = &entry.next;
    }
    *link = static_cast<std::uint32_t>(entries_.size());
    entries_.push_back({above, kNone, kNone});
    return entries_.back().point;
  }

  /// Visits the edges from vertices at and after `begin`.
  template <class Visit>
  void forEachFrom(std::uint32_t begin, Visit visit) const {
    for (std::uint32_t below = begin; below < first_.size(); ++below) {
      for (std::uint32_t i = first_[below]; i != kNone; i = entries_[i].next) {
        visit(below, entries_[i].above, entries_[i].point);
      }
    }
    for (const auto& [edge, point] : others_) {
      const auto below = static_cast<std::uint32_t>(edge >> 32U);
      if (below >= begin) visit(below, static_cast<std::uint32_t>(edge), point);
    }
  }

 private:
  struct Entry {
    std::uint32_t above;
    std::uint32_t point;
    std::uint32_t next;
  };
  std::vector<std::uint32_t> first_;  // per vertex, kNone if no edge is cut
  std::unordered_map<std::uint64_t, std::uint32_t> others_;
  static constexpr int kLongestChain = 32;
  std::vector<Entry> entries_;
};

Slicer::Slicer(const Hyperplane& hyperplane, OnHyperplane rule)
    : hyperplane_(scaledHyperplane(hyperplane)),
      basis_(basisOf(hyperplane)),
      rule_(rule),
      table_(std::make_unique<PointTable>()) {}

Slicer::~Slicer() = default;

/// The vertex of the slice where the edge between two vertices of the slab is cut.
std::uint32_t Slicer::cutPoint(const Slab& slab, std::uint32_t below, std::uint32_t above) {
  if (height_[below] == 0) above = below;
  if (height_[above] == 0) below = above;
  std::uint32_t& found = table_->at(below, above);
  if (found != kNone) return found;
  found = static_cast<std::uint32_t>(slice_.mesh.vertices.size());
  const double drop = height_[below];
  const double fraction = below == above ? 0 : drop / (drop - height_[above]);
  const Point4 point =
      slab.vertices[below] + fraction * (slab.vertices[above] - slab.vertices[below]);
  slice_.mesh.vertices.push_back(basis_.axes * point);
  points_.push_back({below, above, fraction});
  return found;
}

Result<void> Slicer::check(const Slab& slab) {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return checked;
  if (slab.connectivity != checked_ && slab.connectivity) {
    if (auto checked = checkConnectivity(*slab.connectivity); !checked) return checked;
    checked_ = slab.connectivity;
  }
  return checkSlab(slab);
}

Result<void> Slicer::put(const Slab& slab) {
  if (auto checked = check(slab); !checked) return checked;
  const model::Connectivity& connectivity = *slab.connectivity;

  // Points on the seam are known from the previous slab, by their indices in its upper layer.
  std::vector<std::array<std::uint32_t, 3>> seam;
  if (connectivity.lowerCount == lastUpperCount_) {
    table_->forEachFrom(lastFirstUpper_,
                        [&](std::uint32_t below, std::uint32_t above, std::uint32_t point) {
                          if (above < lastFirstUpper_) return;
                          seam.push_back({below - lastFirstUpper_, above - lastFirstUpper_, point});
                        });
  }
  table_->clear(slab.vertices.size());
  for (const auto& [below, above, point] : seam) table_->at(below, above) = point;
  lastFirstUpper_ = connectivity.firstUpper();
  lastUpperCount_ = connectivity.upperCount;
  ++slice_.slabsRead;

  height_.resize(slab.vertices.size());
  std::vector<std::uint8_t> isAbove(slab.vertices.size());
  for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
    height_[i] = along(hyperplane_.normal, slab.vertices[i]) - hyperplane_.offset;
    isAbove[i] = rule_ == OnHyperplane::Above ? height_[i] >= 0 : height_[i] > 0;
  }

  points_.clear();
  firstPoint_ = slice_.mesh.vertices.size();
  const std::size_t firstTriangle = slice_.mesh.triangles.size();
  std::vector<std::uint32_t> cells;  // of each new triangle
  for (std::uint32_t index = 0; index < connectivity.cells.size(); ++index) {
    const Cell& cell = connectivity.cells[index];
    const unsigned pattern =
        isAbove[cell[0]] | isAbove[cell[1]] << 1U | isAbove[cell[2]] << 2U | isAbove[cell[3]] << 3U;
    const Section& section = sections()[pattern];
    if (section.size == 0) continue;
    std::array<std::uint32_t, 4> corner{};
    for (int i = 0; i < section.size; ++i) {
      corner[i] = cutPoint(slab, cell[section.edges[i].below], cell[section.edges[i].above]);
    }
    for (int i = 1; i + 1 < section.size; ++i) {
      Triangle triangle = {corner[0], corner[i], corner[i + 1]};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
        continue;
      }
      if (!basis_.rightHanded) std::swap(triangle[1], triangle[2]);
      slice_.mesh.triangles.push_back(triangle);
      cells.push_back(index);
    }
  }
  numberAsInLayer(firstPoint_, firstTriangle);
  if (!cells.empty()) carryAttributes(slab, cells);
  return {};
}

/// If all points of a section are vertices of the slab, they are sorted in the order of the slab,
/// so that the slice at a layer is numbered like the input.
void Slicer::numberAsInLayer(std::size_t firstPoint, std::size_t firstTriangle) {
  const bool allVertices = std::all_of(points_.begin(), points_.end(), [](const CutPoint& point) {
    return point.below == point.above;
  });
  if (!allVertices || firstPoint != 0) return;
  std::vector<std::uint32_t> order(points_.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return points_[a].below < points_[b].below; });
  std::vector<std::uint32_t> number(order.size());
  std::vector<CutPoint> points;
  std::vector<model::Point3> vertices;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    number[order[i]] = i;
    points.push_back(points_[order[i]]);
    vertices.push_back(slice_.mesh.vertices[order[i]]);
    table_->at(points[i].below, points[i].above) = i;
  }
  points_ = std::move(points);
  slice_.mesh.vertices = std::move(vertices);
  for (std::size_t i = firstTriangle; i < slice_.mesh.triangles.size(); ++i) {
    for (std::uint32_t& vertex : slice_.mesh.triangles[i]) vertex = number[vertex];
  }
}

namespace {

template <class Scalar>
void interpolate(const std::byte* below, const std::byte* above, double fraction,
                 std::size_t components, std::byte* into) {
  for (std::size_t i = 0; i < components; ++i) {
    Scalar a;
    Scalar b;
    std::memcpy(&a, below + i * sizeof(Scalar), sizeof(Scalar));
    std::memcpy(&b, above + i * sizeof(Scalar), sizeof(Scalar));
    const auto value = static_cast<Scalar>(a + fraction * (static_cast<double>(b) - a));
    std::memcpy(into + i * sizeof(Scalar), &value, sizeof(Scalar));
  }
}

}  // namespace

/// Appends the rows of the new triangles and vertices to the slice's attributes. The first slab
/// that is cut defines them; an attribute that a later slab lacks is lost.
void Slicer::carryAttributes(const Slab& slab, const std::vector<std::uint32_t>& cells) {
  std::vector<const Attribute*> given;
  for (const Attribute& attribute : slab.connectivity->cellAttributes) given.push_back(&attribute);
  for (const Attribute& attribute : slab.attributes) given.push_back(&attribute);
  std::vector<Attribute>& carried = slice_.mesh.attributes;
  if (!hasAttributes_) {
    hasAttributes_ = true;
    for (const Attribute* attribute : given) {
      carried.push_back(
          {attribute->name, attribute->domain, attribute->type, attribute->components, {}});
    }
  }
  const auto match = [&](const Attribute& wanted) -> const Attribute* {
    const auto at = std::find_if(given.begin(), given.end(), [&](const Attribute* attribute) {
      return attribute->name == wanted.name && attribute->domain == wanted.domain &&
             attribute->type == wanted.type && attribute->components == wanted.components;
    });
    return at == given.end() ? nullptr : *at;
  };
  std::erase_if(carried, [&](const Attribute& attribute) {
    if (match(attribute) != nullptr) return false;
    slice_.losses.push_back(
        fmt::format("attribute '{}': not every slab that was cut has it", attribute.name));
    return true;
  });
  for (Attribute& attribute : carried) {
    const Attribute& from = *match(attribute);
    const std::size_t bytes = from.rowBytes();
    if (attribute.domain == Domain::Cell) {
      for (const std::uint32_t cell : cells) {
        attribute.values.insert(attribute.values.end(), from.row(cell), from.row(cell) + bytes);
      }
      continue;
    }
    std::vector<std::byte> row(bytes);
    for (const CutPoint& point : points_) {
      std::memcpy(row.data(), from.row(point.below), bytes);
      if (from.type == ScalarType::Float64) {
        interpolate<double>(from.row(point.below), from.row(point.above), point.fraction,
                            from.components, row.data());
      } else if (from.type == ScalarType::Float32) {
        interpolate<float>(from.row(point.below), from.row(point.above), point.fraction,
                           from.components, row.data());
      }
      attribute.values.insert(attribute.values.end(), row.begin(), row.end());
    }
  }
}

Slice Slicer::finish() { return std::move(slice_); }

Result<Slice> sliceAtTime(const model::Source& source, double given) {
  const model::TimeSpan span = timeSpanOf(source);
  const auto meant = model::timeWithin(source, given);
  if (!meant) {
    if (source.slabCount() == 0) return invalid("the mesh has no slabs");
    return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", given,
                               span.begin, span.end));
  }
  const double time = *meant;
  // The first slab that ends later or, at the very end, the first that ends there.
  const bool atEnd = time == span.end;
  std::size_t low = 0;
  std::size_t high = source.slabCount();
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    const bool reaches =
        atEnd ? source.timeSpan(middle).end >= time : source.timeSpan(middle).end > time;
    if (reaches) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  Slicer slicer(Hyperplane::atTime(time), atEnd ? OnHyperplane::Above : OnHyperplane::Below);
  // Between runs of slabs the solid is empty, and there is nothing to read.
  if (low < source.slabCount() && source.timeSpan(low).begin <= time) {
    auto slab = source.slab(low);
    if (!slab) return pass(slab.error());
    if (auto put = slicer.put(**slab); !put) return pass(put.error());
  }
  return slicer.finish();
}

Result<Slice> slice(const model::Source& source, const Hyperplane& hyperplane,
                    const model::Progress& progress) {
  if (auto checked = checkHyperplane(hyperplane); !checked) return pass(checked.error());
  const Eigen::Vector4d& n = hyperplane.normal;
  if (n.head<3>().isZero(0)) return sliceAtTime(source, hyperplane.offset / n[3]);
  Slicer slicer(hyperplane);
  if (auto done = pump(source, slicer, progress); !done) return pass(done.error());
  return slicer.finish();
}

}  // namespace t4d::convert
