#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "measure/exact_signs.h"
#include "measure/slab_measure.h"
#include "model/facets.h"
#include "model/parallel.h"
#include "model/union_find.h"
#include "t4d/envelope.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::Cell;
using model::Connectivity;
using model::Point3;
using model::Slab;

constexpr std::uint32_t kOpen = ~std::uint32_t{0};
constexpr std::uint32_t kLayer = kOpen - 1;
// Cells that are measured together; the sums do not depend on the number of threads.
constexpr std::size_t kBlock = 8192;

}  // namespace

/// The neighbours of the cells of a slab.
class SilhouetteTopology {
 public:
  /// A facet in a layer that one cell of the slab has. Vertices are numbered from the first of the
  /// layer.
  struct LayerFacet {
    std::array<std::uint32_t, 3> vertices;  // increasing
    bool even;                              // whether the cell has it in this orientation
    std::uint32_t cell;
  };

  explicit SilhouetteTopology(std::shared_ptr<const Connectivity> connectivity)
      : connectivity_(std::move(connectivity)), neighbours_(connectivity_->cells.size()) {
    const std::vector<Cell>& cells = connectivity_->cells;
    std::vector<std::uint64_t> counts(connectivity_->vertexCount);
    for (const Cell& cell : cells) {
      std::array<std::uint32_t, 4> sorted = cell;
      std::ranges::sort(sorted);
      counts[sorted[0]] += 3;
      ++counts[sorted[1]];
    }
    // The work is in parts, so that memory stays well below that of the neighbours.
    constexpr std::uint64_t kPart = std::uint64_t{1} << 22;
    const std::uint64_t most = std::max<std::uint64_t>(kPart, cells.size() / 2);
    std::uint64_t sides = 0;
    std::uint32_t begin = 0;
    for (std::uint32_t vertex = 0; vertex < connectivity_->vertexCount; ++vertex) {
      sides += counts[vertex];
      if (sides < most && vertex + 1 < connectivity_->vertexCount) continue;
      addPart(begin, vertex + 1, counts);
      begin = vertex + 1;
      sides = 0;
    }
    std::ranges::sort(lower_, {}, &LayerFacet::vertices);
    std::ranges::sort(upper_, {}, &LayerFacet::vertices);
  }

  const Connectivity& connectivity() const { return *connectivity_; }
  bool isOf(const std::shared_ptr<const Connectivity>& connectivity) const {
    return connectivity_ == connectivity;
  }
  /// The cell on the other side of the facet opposite a corner, kLayer, or kOpen.
  std::uint32_t neighbour(std::size_t cell, int corner) const { return neighbours_[cell][corner]; }
  const std::vector<LayerFacet>& lower() const { return lower_; }
  const std::vector<LayerFacet>& upper() const { return upper_; }

  Result<void> checkClosed() const {
    if (open_ == 0) return {};
    return invalid(
        fmt::format("the mesh is not closed: facet {}-{}-{} does not have one cell on "
                    "each side ({} such facets)",
                    firstOpen_[0], firstOpen_[1], firstOpen_[2], open_));
  }

 private:
  /// One facet of one cell, without its smallest vertex.
  struct CellSide {
    std::uint64_t others;
    std::uint32_t cell;
    std::uint8_t corner;
    bool even;
  };

  /// The facets whose smallest vertex lies in a range.
  void addPart(std::uint32_t begin, std::uint32_t end, std::span<const std::uint64_t> counts) {
    std::vector<std::size_t> ends(end - begin);
    std::exclusive_scan(counts.begin() + begin, counts.begin() + end, ends.begin(), std::size_t{0});
    std::vector<CellSide> sides(ends.empty() ? 0 : ends.back() + counts[end - 1]);
    for (std::size_t i = 0; i < connectivity_->cells.size(); ++i) {
      for (int corner = 0; corner < 4; ++corner) {
        const auto [vertices, even] = model::facetOpposite(connectivity_->cells[i], corner);
        if (vertices[0] < begin || vertices[0] >= end) continue;
        sides[ends[vertices[0] - begin]++] = {std::uint64_t{vertices[1]} << 32 | vertices[2],
                                              static_cast<std::uint32_t>(i),
                                              static_cast<std::uint8_t>(corner), even};
      }
    }
    auto at = sides.begin();
    for (std::uint32_t low = begin; low < end; ++low) {
      const auto bucketEnd = sides.begin() + static_cast<std::ptrdiff_t>(ends[low - begin]);
      std::sort(at, bucketEnd,
                [](const CellSide& a, const CellSide& b) { return a.others < b.others; });
      while (at != bucketEnd) {
        auto next = at + 1;
        while (next != bucketEnd && next->others == at->others) ++next;
        addFacet(low, {at, next});
        at = next;
      }
    }
  }

  void addFacet(std::uint32_t low, std::span<const CellSide> sides) {
    const std::array<std::uint32_t, 3> vertices = {
        low, static_cast<std::uint32_t>(sides[0].others >> 32),
        static_cast<std::uint32_t>(sides[0].others)};
    if (sides.size() == 2 && sides[0].even != sides[1].even) {
      neighbours_[sides[0].cell][sides[0].corner] = sides[1].cell;
      neighbours_[sides[1].cell][sides[1].corner] = sides[0].cell;
      return;
    }
    const bool isLower = vertices[2] < connectivity_->lowerCount;
    const std::uint32_t first = connectivity_->firstUpper();
    if (sides.size() == 1 && (isLower || low >= first)) {
      neighbours_[sides[0].cell][sides[0].corner] = kLayer;
      LayerFacet facet{vertices, sides[0].even, sides[0].cell};
      if (!isLower) {
        for (std::uint32_t& vertex : facet.vertices) vertex -= first;
      }
      (isLower ? lower_ : upper_).push_back(facet);
      return;
    }
    for (const CellSide& side : sides) neighbours_[side.cell][side.corner] = kOpen;
    if (open_++ == 0) firstOpen_ = vertices;
  }

  std::shared_ptr<const Connectivity> connectivity_;
  std::vector<std::array<std::uint32_t, 4>> neighbours_;
  std::vector<LayerFacet> lower_;
  std::vector<LayerFacet> upper_;
  std::uint64_t open_ = 0;
  std::array<std::uint32_t, 3> firstOpen_ = {0, 0, 0};
};

namespace {

/// Slabs partly cancel (Kahan).
void addCompensated(double& sum, double& carry, double value) {
  const double corrected = value - carry;
  const double next = sum + corrected;
  carry = (next - sum) - corrected;
  sum = next;
}

/// The cells of a slab that are exits, and their measures.
struct SlabExits {
  std::vector<std::uint8_t> isExit;
  double visitsVolume = 0;
  double hypervolume = 0;
  double volume = 0;  // of all cells, with their signs
  std::uint64_t exits = 0;
  std::uint64_t entries = 0;
};

/// Where the vertices of a slab would be in a frame that moves along with the solid: a shear, which
/// keeps all volumes. In it the cells of a small solid that moves far are small, so their volumes
/// do not cancel.
class Comoving {
 public:
  explicit Comoving(const Slab& slab) {
    if (slab.vertices.empty()) return;
    origin_ = slab.vertices.front();
    const Connectivity& connectivity = *slab.connectivity;
    const double duration = slab.timeEnd - slab.timeBegin;
    if (!(duration > 0) || connectivity.lowerCount == 0 || connectivity.upperCount == 0) return;
    const auto mean = [&](std::size_t first, std::size_t count) {
      Point3 sum = Point3::Zero();
      for (std::size_t i = first; i < first + count; ++i) {
        sum += (slab.vertices[i] - origin_).head<3>();
      }
      return Point3(sum / static_cast<double>(count));
    };
    velocity_ = (mean(connectivity.firstUpper(), connectivity.upperCount) -
                 mean(0, connectivity.lowerCount)) /
                duration;
    if (!velocity_.allFinite()) velocity_ = Point3::Zero();
  }

  Point3 operator()(const model::Point4& vertex) const {
    const model::Point4 from = vertex - origin_;
    return from.head<3>() - from[3] * velocity_;
  }

 private:
  model::Point4 origin_ = model::Point4::Zero();
  Point3 velocity_ = Point3::Zero();
};

/// Times are measured from `origin`.
SlabExits exitsOf(const Slab& slab, double origin) {
  const Comoving comoving(slab);
  const Connectivity& connectivity = *slab.connectivity;
  const std::vector<Cell>& cells = connectivity.cells;
  const bool isFlat = slab.timeBegin == slab.timeEnd;
  const bool isEnd = isFlat && connectivity.lowerCount > 0 && connectivity.upperCount == 0;
  const bool isStart = isFlat && connectivity.lowerCount == 0 && connectivity.upperCount > 0;
  SlabExits found;
  found.isExit.resize(cells.size());
  std::vector<SlabExits> sums((cells.size() + kBlock - 1) / kBlock);
  model::forEach(sums.size(), [&](std::size_t block) {
    SlabExits& sum = sums[block];
    for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, cells.size()); ++i) {
      const auto corner = [&](int k) -> Point3 { return slab.vertices[cells[i][k]].head<3>(); };
      const Point3 a = corner(0);
      const Point3 b = corner(1);
      const Point3 c = corner(2);
      const Point3 d = corner(3);
      // det[n, b - a, c - a, d - a] with n along t is minus the determinant in space.
      const int sign = -orientation(a, b, c, d);
      if (sign != 0) ++(sign > 0 ? sum.exits : sum.entries);
      const bool isExit = isEnd || (!isStart && sign > 0);
      found.isExit[i] = isExit ? 1 : 0;
      const auto volumeOf = [](const Point3& p, const Point3& q, const Point3& r, const Point3& s) {
        return -(q - p).cross(r - p).dot(s - p) / 6;
      };
      if (isExit && sign != 0) sum.visitsVolume += volumeOf(a, b, c, d);
      double time = 0;
      for (int k = 0; k < 4; ++k) time += slab.vertices[cells[i][k]][3] - origin;
      const auto moved = [&](int k) { return comoving(slab.vertices[cells[i][k]]); };
      const double volume = volumeOf(moved(0), moved(1), moved(2), moved(3));
      sum.volume += volume;
      sum.hypervolume += volume * time / 4;
    }
  });
  for (const SlabExits& sum : sums) {
    found.visitsVolume += sum.visitsVolume;
    found.hypervolume += sum.hypervolume;
    found.volume += sum.volume;
    found.exits += sum.exits;
    found.entries += sum.entries;
  }
  return found;
}

/// The smallest extent of some points along the axes or along their own principal axes.
double leastExtentOf(std::span<const Point3> points) {
  Point3 mean = Point3::Zero();
  for (const Point3& point : points) mean += point / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Point3& point : points) spread += (point - mean) * (point - mean).transpose();
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  model::Bounds3 bounds;
  model::Bounds3 turned;
  for (const Point3& point : points) {
    bounds.add(point);
    turned.add(axes.transpose() * (point - mean));
  }
  return std::min((bounds.max - bounds.min).minCoeff(), (turned.max - turned.min).minCoeff());
}

/// The smallest extent of a component of a slab that is not zero.
double partExtentOf(const Slab& slab) {
  model::UnionFind parts(slab.vertices.size());
  std::vector<bool> used(slab.vertices.size());
  for (const Cell& cell : slab.connectivity->cells) {
    for (const std::uint32_t vertex : cell) {
      parts.unite(cell[0], vertex);
      used[vertex] = true;
    }
  }
  std::vector<std::vector<Point3>> points(slab.vertices.size());
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    if (used[i]) points[parts.root(i)].push_back(slab.vertices[i].head<3>());
  }
  double least = 0;
  for (const auto& part : points) {
    if (part.empty()) continue;
    const double extent = leastExtentOf(part);
    if (extent > 0 && (least == 0 || extent < least)) least = extent;
  }
  return least;
}

Result<void> check(const Slab& slab, const SilhouetteTopology* known) {
  if (!slab.connectivity) return invalid("has no connectivity");
  if (known == nullptr || !known->isOf(slab.connectivity)) {
    if (auto sound = model::checkConnectivity(*slab.connectivity); !sound) return sound;
  }
  return model::checkSlab(slab);
}

}  // namespace

/// The triangles of a silhouette, with vertices of slabs numbered as they come.
class SilhouetteSurface {
 public:
  explicit SilhouetteSurface(model::TriangleMesh& surface) : surface_(surface) {}

  /// Begins a slab; its lower layer is the upper one of the slab before.
  void begin(const Slab& slab) {
    const VertexIds before = std::move(ids_);
    ids_.assign(slab.vertices.size(), model::kNoIndex);
    const std::uint32_t lower = slab.connectivity->lowerCount;
    if (before.size() >= lower) std::copy(before.end() - lower, before.end(), ids_.begin());
    slab_ = &slab;
  }

  /// Adds a facet of an exit.
  void add(std::array<std::uint32_t, 3> vertices, bool even) {
    for (std::uint32_t& vertex : vertices) vertex = idOf(vertex);
    // An exit is negatively oriented in space.
    if (even) std::swap(vertices[1], vertices[2]);
    surface_.triangles.push_back(vertices);
  }

  /// Adds the facets between exits and cells of the slab that are none.
  void addWithin(const SilhouetteTopology& topology, const std::vector<std::uint8_t>& isExit) {
    const std::vector<Cell>& cells = topology.connectivity().cells;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (isExit[i] == 0) continue;
      for (int corner = 0; corner < 4; ++corner) {
        const std::uint32_t neighbour = topology.neighbour(i, corner);
        if (neighbour >= kLayer || isExit[neighbour] != 0) continue;
        const auto [vertices, even] = model::facetOpposite(cells[i], corner);
        add(vertices, even);
      }
    }
  }

 private:
  using VertexIds = std::vector<std::uint32_t>;

  std::uint32_t idOf(std::uint32_t vertex) {
    if (ids_[vertex] == model::kNoIndex) {
      ids_[vertex] = static_cast<std::uint32_t>(surface_.vertices.size());
      surface_.vertices.emplace_back(slab_->vertices[vertex].head<3>());
    }
    return ids_[vertex];
  }

  model::TriangleMesh& surface_;
  VertexIds ids_;  // of the current slab, then of the upper layer
  const Slab* slab_ = nullptr;
};

struct SilhouetteBuilder::State {
  Silhouette result;
  SilhouetteSurface parts{result.surface};
  std::shared_ptr<const SilhouetteTopology> before;
  std::vector<std::uint8_t> upperExits;  // for each upper facet of the slab before, of its cell
  double visitsCarry = 0;
  double hypervolumeCarry = 0;
  double fluxCarry = 0;
  std::uint64_t slabs = 0;
  double timeBegin = 0;
  double timeEnd = 0;
  // The last two whose layers fit.
  std::shared_ptr<const SilhouetteTopology> fitBefore;
  std::shared_ptr<const SilhouetteTopology> fitAfter;

  Result<void> addSeam(const std::shared_ptr<const SilhouetteTopology>& after,
                       const std::vector<std::uint8_t>& isExit, double time) {
    static const std::vector<SilhouetteTopology::LayerFacet> kNone;
    const auto& below = before ? before->upper() : kNone;
    const auto& above = after ? after->lower() : kNone;
    if (!(fitBefore == before && fitAfter == after) || !before || !after) {
      const bool fit = std::equal(below.begin(), below.end(), above.begin(), above.end(),
                                  [](const auto& a, const auto& b) {
                                    return a.vertices == b.vertices && a.even != b.even;
                                  });
      if (!fit) {
        return invalid(
            fmt::format("the mesh is not closed at time {}: the cells before and after "
                        "it do not fit together",
                        time));
      }
      fitBefore = before;
      fitAfter = after;
    }
    for (std::size_t i = 0; i < above.size(); ++i) {
      const bool exitBelow = upperExits[i] != 0;
      const bool exitAbove = isExit[above[i].cell] != 0;
      if (exitBelow != exitAbove) {
        parts.add(above[i].vertices, exitAbove ? above[i].even : below[i].even);
      }
    }
    return {};
  }
};

SilhouetteBuilder::SilhouetteBuilder() : state_(std::make_unique<State>()) {}
SilhouetteBuilder::~SilhouetteBuilder() = default;

Result<void> SilhouetteBuilder::put(const Slab& slab) {
  State& state = *state_;
  const auto inSlab = [&](Error error) {
    error.where = placeIn({}, fmt::format("slab {}", state.slabs));
    return error;
  };
  if (auto sound = check(slab, state.before.get()); !sound) return inSlab(sound.error());
  std::shared_ptr<const SilhouetteTopology> topology = state.before;
  if (!topology || !topology->isOf(slab.connectivity)) {
    topology = std::make_shared<const SilhouetteTopology>(slab.connectivity);
    if (auto closed = topology->checkClosed(); !closed) return inSlab(closed.error());
  }
  if (state.slabs == 0) {
    state.timeBegin = slab.timeBegin;
    model::Bounds3 bounds;
    for (const model::Point4& vertex : slab.vertices) bounds.add(Point3(vertex.head<3>()));
    if (!bounds.empty()) state.result.solidExtent = (bounds.max - bounds.min).maxCoeff();
    state.result.partExtent = partExtentOf(slab);
  }
  const SlabExits found = exitsOf(slab, state.timeBegin);
  state.parts.begin(slab);
  if (auto fit = state.addSeam(topology, found.isExit, slab.timeBegin); !fit) {
    return inSlab(fit.error());
  }
  state.parts.addWithin(*topology, found.isExit);
  if (slab.timeBegin == slab.timeEnd) {
    state.result.solidVolume = std::max(state.result.solidVolume, std::abs(found.volume));
  }
  state.upperExits.clear();
  for (const auto& facet : topology->upper()) {
    state.upperExits.push_back(found.isExit[facet.cell]);
  }
  if (state.result.surface.vertices.size() >= model::kNoIndex - slab.vertices.size()) {
    return fail(ErrorCode::Unsupported, "the silhouette has too many vertices");
  }
  addCompensated(state.result.visitsVolume, state.visitsCarry, found.visitsVolume);
  addCompensated(state.result.hypervolumeByFlux, state.fluxCarry,
                 measureOf(slab, model::Point4::Zero()).hypervolume);
  addCompensated(state.result.hypervolume, state.hypervolumeCarry, found.hypervolume);
  state.result.exits += found.exits;
  state.result.entries += found.entries;
  state.before = std::move(topology);
  state.timeEnd = slab.timeEnd;
  ++state.slabs;
  return {};
}

Result<Silhouette> SilhouetteBuilder::finish() {
  State& state = *state_;
  if (auto closed = state.addSeam(nullptr, {}, state.timeEnd); !closed) return closed.error();
  return std::move(state.result);
}

Result<Silhouette> silhouetteOf(const model::Source& source, const model::Progress& progress) {
  SilhouetteBuilder builder;
  if (auto put = model::pump(source, builder, progress); !put) return put.error();
  return builder.finish();
}

SlabSilhouettes::SlabSilhouettes() = default;
SlabSilhouettes::~SlabSilhouettes() = default;

Result<Silhouette> SlabSilhouettes::of(const Slab& slab) {
  if (auto sound = check(slab, topology_.get()); !sound) return sound.error();
  Silhouette result;
  if (slab.timeBegin == slab.timeEnd) return result;
  if (!topology_ || !topology_->isOf(slab.connectivity)) {
    topology_ = std::make_shared<const SilhouetteTopology>(slab.connectivity);
  }
  if (auto closed = topology_->checkClosed(); !closed) return closed.error();
  SlabExits found = exitsOf(slab, slab.timeBegin);
  SilhouetteSurface parts(result.surface);
  parts.begin(slab);
  parts.addWithin(*topology_, found.isExit);
  // Below lies an entry, above an exit: the solid at the slab's two times.
  for (const auto& facet : topology_->lower()) {
    if (found.isExit[facet.cell] != 0) parts.add(facet.vertices, facet.even);
  }
  const std::uint32_t first = slab.connectivity->firstUpper();
  model::TriangleMesh end;
  for (const auto& facet : topology_->upper()) {
    std::array<std::uint32_t, 3> vertices = facet.vertices;
    for (std::uint32_t& vertex : vertices) vertex += first;
    if (found.isExit[facet.cell] == 0) parts.add(vertices, !facet.even);
    if (!facet.even) std::swap(vertices[1], vertices[2]);
    end.triangles.push_back(vertices);
  }
  for (const model::Point4& vertex : slab.vertices) end.vertices.emplace_back(vertex.head<3>());
  const double endVolume = model::signedVolume(end);
  result.visitsVolume = found.visitsVolume + endVolume;
  result.hypervolume = found.hypervolume + endVolume * (slab.timeEnd - slab.timeBegin);
  result.exits = found.exits;
  result.entries = found.entries;
  return result;
}

}  // namespace t4d::measure
