#include "edit/collapse_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "edit/cell_complex.h"
#include "edit/cell_shape.h"
#include "edit/near_samples.h"
#include "edit/slice_topology.h"
#include "edit/value_borders.h"
#include "edit/vertex_placement.h"
#include "model/cell_normal.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Cell;
using model::Domain;
using model::Point3;
using model::Point4;

constexpr double kLeastCosine = 0.342;  // of 70 degrees

/// Another round follows one that has collapsed an edge for each so many cells.
constexpr std::uint64_t kFewestOfCells = 500;

/// The freedom of a vertex to move.
enum class Hold : std::uint8_t { Free, Time, Place };

/// An edge that may be collapsed.
struct Candidate : Collapse {
  double cost;
  std::uint32_t version;  // of both ends when the cost was computed
};

/// Tried one after another, as long as the place turns cells over: towards the middle of the edge,
/// then towards its ends, as a flat part may need.
constexpr std::array<Pull, 5> kPulls = {{{0.5, 1e-6}, {0, 1e-4}, {1, 1e-4}, {0, 1e-1}, {1, 1e-1}}};

/// For a heap with the least cost on top; ties are decided by the vertices.
bool isLater(const Candidate& one, const Candidate& other) {
  if (one.cost != other.cost) return one.cost > other.cost;
  return one.a != other.a ? one.a > other.a : one.b > other.b;
}

class PatchCollapser {
 public:
  PatchCollapser(Patch patch, const CollapseOptions& options)
      : patch_(std::move(patch)),
        options_(options),
        complex_(patch_.cells, patch_.vertexCount()),
        holds_(patch_.vertices.size(), Hold::Free),
        topology_(complex_, patch_.vertices),
        borders_(complex_, patch_, options.preserve),
        samples_(std::move(patch_.samples), patch_.cells.size(), options.original),
        normals_(patch_.vertices.size(), Point4::Zero()),
        areas_(patch_.vertices.size(), 0),
        versions_(patch_.vertices.size(), 0),
        joinedTo_(patch_.vertices.size()) {
    for (std::uint32_t i = 0; i < joinedTo_.size(); ++i) joinedTo_[i] = i;
    for (std::uint32_t cell = 0; cell < patch_.cells.size(); ++cell) {
      addNormals(patch_.cells[cell], normalOf(cell), 1);
    }
    holdVertices();
    borders_.weigh(patch_);
  }

  CollapsedPatch run() {
    if (options_.only != nullptr) {
      for (const Collapse& one : *options_.only) {
        if (!complex_.isUsed(one.a) || !complex_.isUsed(one.b)) continue;
        if (const auto placement = exactPlacement(one)) tryCollapse(one, placement->place);
      }
      return finish();
    }
    while (complex_.liveCells() > options_.cells) {
      queueAll();
      // What was refused may be possible now, but a round for a few edges takes too long.
      if (collapseQueued() <= complex_.liveCells() / kFewestOfCells) break;
    }
    return finish();
  }

 private:
  // --- what vertices may do

  void holdVertices() {
    std::vector<bool> isAtOneTime(patch_.vertices.size());
    for (const Cell& cell : patch_.cells) {
      if (!measure::isAtOneTime(cornersOf(patch_.vertices, cell))) continue;
      for (const std::uint32_t corner : cell) isAtOneTime[corner] = true;
    }
    for (std::uint32_t i = 0; i < patch_.vertexCount(); ++i) {
      const double time = patch_.vertices[i][3];
      if (patch_.isInLayer(i)) {
        holds_[i] = Hold::Place;
      } else if (isAtOneTime[i] || patch_.isInSeam(i) || time == options_.firstTime ||
                 time == options_.lastTime) {
        holds_[i] = Hold::Time;
      }
      if (holds_[i] == Hold::Place) continue;
      if (!topology_.hasSphere(i, /*remember=*/!isAtOneTime[i])) {
        holds_[i] = Hold::Place;  // the apex of a cap that is a cone, for instance
      } else if (topology_.isCritical(i)) {
        holds_[i] = Hold::Time;
      }
    }
  }

  /// Whether the edge is one to collapse: its ends are not held against each other.
  bool mayJoin(std::uint32_t a, std::uint32_t b) const {
    if (holds_[a] == Hold::Place || holds_[b] == Hold::Place) return false;
    if (holds_[a] == Hold::Free || holds_[b] == Hold::Free) return true;
    return patch_.vertices[a][3] == patch_.vertices[b][3] &&
           !(topology_.isCritical(a) && topology_.isCritical(b));
  }

  /// Which of two vertices remains: that of the seam, or that which is held.
  bool remainsBefore(std::uint32_t a, std::uint32_t b) const {
    if (patch_.isInSeam(a) != patch_.isInSeam(b)) return patch_.isInSeam(a);
    if (holds_[a] != holds_[b]) return holds_[a] > holds_[b];
    return a < b;
  }

  // --- normals

  Eigen::Vector4d normalOf(std::uint32_t cell) const {
    return model::cellNormal(cornersOf(patch_.vertices, complex_.cells()[cell]));
  }

  void addNormals(const Cell& cell, const Eigen::Vector4d& normal, double sign) {
    const double size = normal.norm();
    for (const std::uint32_t corner : cell) {
      normals_[corner] += sign * normal;
      areas_[corner] += sign * size;
    }
  }

  bool isCornerOf(std::uint32_t cell, std::uint32_t vertex) const {
    return hasCorner(complex_.cells()[cell], vertex);
  }

  // --- the queue

  void queueAll() {
    queue_.clear();
    for (std::uint32_t vertex = 0; vertex < patch_.vertexCount(); ++vertex) {
      if (holds_[vertex] == Hold::Place || !complex_.isUsed(vertex)) continue;
      queueEdgesOf(vertex, [&](std::uint32_t other) { return other > vertex; });
    }
    std::ranges::make_heap(queue_, isLater);
    isHeap_ = true;
  }

  /// Queues the edges of a vertex to those of its neighbours that are wanted.
  template <class Wanted>
  void queueEdgesOf(std::uint32_t vertex, Wanted wanted) {
    shared_.clear();
    complex_.eachCell(vertex, [&](std::uint32_t cell, int) {
      const Eigen::Vector4d normal = normalOf(cell);
      for (const std::uint32_t corner : complex_.cells()[cell]) {
        if (corner != vertex && wanted(corner) && mayJoin(vertex, corner)) {
          sharedOf(corner) += normal;
        }
      }
    });
    for (const auto& [other, normal] : shared_) {
      const bool first = remainsBefore(vertex, other);
      push(first ? vertex : other, first ? other : vertex, normal);
    }
  }

  Eigen::Vector4d& sharedOf(std::uint32_t vertex) {
    const auto found = std::ranges::find(shared_, vertex, &Shared::vertex);
    if (found != shared_.end()) return found->normal;
    return shared_.emplace_back(Shared{vertex, Eigen::Vector4d::Zero()}).normal;
  }

  void push(std::uint32_t a, std::uint32_t b, const Eigen::Vector4d& shared) {
    const auto placement = placementOf(a, b, normals_[a], normals_[b], shared, kPulls[0]);
    if (!placement) return;
    queue_.push_back({{a, b, 0}, placement->cost, versions_[a] + versions_[b]});
    if (isHeap_) std::ranges::push_heap(queue_, isLater);
  }

  std::optional<VertexPlacement> placementOf(std::uint32_t a, std::uint32_t b,
                                             const Eigen::Vector4d& normalA,
                                             const Eigen::Vector4d& normalB,
                                             const Eigen::Vector4d& shared,
                                             const Pull& pull) const {
    EdgeCollapse edge;
    edge.edge = patch_.vertices[b] - patch_.vertices[a];
    edge.quadric = patch_.quadrics[b].about(-edge.edge);
    edge.quadric += patch_.quadrics[a];
    edge.normal = normalA + normalB - shared;
    edge.flux = normalB.dot(edge.edge);
    edge.starArea = areas_[a] + areas_[b];
    if (holds_[a] == Hold::Time) edge.time = 0;
    return placeVertex(edge, pull);
  }

  /// Like placementOf, with sums of normals computed anew, free of rounding errors of earlier
  /// collapses.
  std::optional<VertexPlacement> exactPlacement(const Collapse& wanted) const {
    const auto& [a, b, pull] = wanted;
    Eigen::Vector4d normalA = Eigen::Vector4d::Zero();
    Eigen::Vector4d normalB = Eigen::Vector4d::Zero();
    Eigen::Vector4d shared = Eigen::Vector4d::Zero();
    complex_.eachCell(a, [&](std::uint32_t cell, int) {
      const Eigen::Vector4d normal = normalOf(cell);
      normalA += normal;
      if (isCornerOf(cell, b)) shared += normal;
    });
    complex_.eachCell(b, [&](std::uint32_t cell, int) { normalB += normalOf(cell); });
    return placementOf(a, b, normalA, normalB, shared, kPulls[pull]);
  }

  /// Collapses until the queue is empty or enough cells are gone; returns how often.
  std::uint64_t collapseQueued() {
    std::uint64_t count = 0;
    while (!queue_.empty() && complex_.liveCells() > options_.cells) {
      std::ranges::pop_heap(queue_, isLater);
      const Candidate top = queue_.back();
      queue_.pop_back();
      if (!complex_.isUsed(top.a) || !complex_.isUsed(top.b) ||
          top.version != versions_[top.a] + versions_[top.b]) {
        continue;
      }
      const auto placement = exactPlacement(top);
      if (!placement) continue;
      if (isStale(top, placement->cost)) {
        requeue(top, placement->cost);
      } else if (tryCollapse(top, placement->place)) {
        ++count;
      } else {
        tryNextPull(top);
      }
    }
    isHeap_ = false;
    return count;
  }

  void requeue(Candidate candidate, double cost) {
    candidate.cost = cost;
    queue_.push_back(candidate);
    std::ranges::push_heap(queue_, isLater);
  }

  void tryNextPull(Candidate candidate) {
    if (++candidate.pull == kPulls.size()) return;
    const auto placement = exactPlacement(candidate);
    if (placement) requeue(candidate, placement->cost);
  }

  /// Whether its neighbours have moved so far that others are cheaper now.
  bool isStale(const Candidate& candidate, double cost) const {
    constexpr double kMuch = 1.1;
    return cost > kMuch * candidate.cost && !queue_.empty() && cost > queue_.front().cost;
  }

  // --- one collapse

  bool tryCollapse(const Collapse& wanted, const Eigen::Vector4d& offset) {
    const auto& [a, b, pull] = wanted;
    const Point4 place = placeOf(a, offset);
    if (!isWithinTime(a, place) || !keepsShapes(a, b, place) || !complex_.canCollapse(a, b) ||
        !topology_.staysIf(a, b, place) || !borders_.stayIf(a, b) || !staysNear(a, b, place)) {
      return false;
    }
    collapse(a, b, place);
    done_.push_back(wanted);
    if (options_.only == nullptr) queueEdgesOf(a, [](std::uint32_t) { return true; });
    return true;
  }

  Point4 placeOf(std::uint32_t a, const Eigen::Vector4d& offset) const {
    Point4 place = patch_.vertices[a] + offset;
    if (holds_[a] == Hold::Time) place[3] = patch_.vertices[a][3];
    return place;
  }

  bool isWithinTime(std::uint32_t a, const Point4& place) const {
    if (!place.allFinite()) return false;
    return holds_[a] == Hold::Time || (place[3] > patch_.timeBegin && place[3] < patch_.timeEnd);
  }

  bool staysNear(std::uint32_t a, std::uint32_t b, const Point4& place) {
    const double reach = std::min(patch_.reaches[a], patch_.reaches[b]);
    return reach >= 0 && samples_.stayNear(complex_, patch_.vertices, a, b, place, reach);
  }

  /// Calls visit(corners before, corners after) for each cell that remains, until it returns false.
  template <class Visit>
  bool eachChanged(std::uint32_t a, std::uint32_t b, const Point4& place, Visit visit) const {
    bool good = true;
    const auto around = [&](std::uint32_t centre, std::uint32_t other) {
      complex_.eachCell(centre, [&](std::uint32_t cell, int k) {
        if (!good || isCornerOf(cell, other)) return;
        const auto before = cornersOf(patch_.vertices, complex_.cells()[cell]);
        auto after = before;
        after[k] = place;
        good = visit(before, after);
      });
    };
    around(a, b);
    if (good) around(b, a);
    return good;
  }

  /// Whether no cell turns over, becomes a needle, or comes to lie at one time.
  bool keepsShapes(std::uint32_t a, std::uint32_t b, const Point4& place) const {
    constexpr double kFloor = kLeastHeight * kLeastHeight;
    double least = kFloor;
    using Corners = std::array<Point4, 4>;
    const Point3 mean = normals_[a].head<3>() + normals_[b].head<3>();
    const bool areSound =
        eachChanged(a, b, place, [&](const Corners& before, const Corners& after) {
          const Eigen::Vector4d normal = model::cellNormal(after);
          const Eigen::Vector4d old = model::cellNormal(before);
          least = std::min(least, squaredHeight(after, normal));
          if (measure::isAtOneTime(after) && !measure::isAtOneTime(before)) return false;
          return normal.squaredNorm() > 0 &&
                 (old.squaredNorm() == 0 || turnsLittle(old, normal, mean));
        });
    return areSound && (least >= kFloor || least >= leastHeightAround(a, b));
  }

  /// Whether a normal turns little in space-time, and its slices face the same way as those around
  /// it, unless they did not before.
  static bool turnsLittle(const Eigen::Vector4d& old, const Eigen::Vector4d& normal,
                          const Point3& mean) {
    if (old.dot(normal) < kLeastCosine * old.norm() * normal.norm()) return false;
    const auto facing = [&](const Eigen::Vector4d& one) {
      const double size = one.head<3>().norm() * mean.norm();
      return size > 0 ? one.head<3>().dot(mean) / size : 1;
    };
    return facing(normal) >= std::min(kLeastCosine, facing(old));
  }

  double leastHeightAround(std::uint32_t a, std::uint32_t b) const {
    double least = 1;
    for (const std::uint32_t centre : {a, b}) {
      complex_.eachCell(centre, [&](std::uint32_t cell, int) {
        const auto corners = cornersOf(patch_.vertices, complex_.cells()[cell]);
        least = std::min(least, squaredHeight(corners, model::cellNormal(corners)));
      });
    }
    return least;
  }

  void collapse(std::uint32_t a, std::uint32_t b, const Point4& place) {
    const auto changeNormals = [&](std::uint32_t centre, double sign) {
      complex_.eachCell(centre, [&](std::uint32_t cell, int) {
        if (centre == b && isCornerOf(cell, a)) return;
        addNormals(complex_.cells()[cell], normalOf(cell), sign);
      });
    };
    changeNormals(a, -1);
    changeNormals(b, -1);
    interpolateAttributes(a, b, place);
    Quadric4 quadric = patch_.quadrics[a].about(place - patch_.vertices[a]);
    quadric += patch_.quadrics[b].about(place - patch_.vertices[b]);
    patch_.quadrics[a] = quadric;
    patch_.reaches[a] = std::min(patch_.reaches[a], patch_.reaches[b]);
    patch_.vertices[a] = place;
    topology_.join(a, b);
    samples_.move();
    joinedTo_[b] = a;
    complex_.collapse(a, b);
    normals_[a].setZero();
    areas_[a] = 0;
    changeNormals(a, 1);
    ++versions_[a];
  }

  void interpolateAttributes(std::uint32_t a, std::uint32_t b, const Point4& place) {
    if (patch_.attributes.empty()) return;
    const Eigen::Vector4d edge = patch_.vertices[b] - patch_.vertices[a];
    const double along = (place - patch_.vertices[a]).dot(edge) / edge.squaredNorm();
    const double fraction = std::isfinite(along) ? std::clamp(along, 0.0, 1.0) : 0;
    for (Attribute& attribute : patch_.attributes) {
      if (attribute.domain != Domain::Vertex) continue;
      std::byte* row = attribute.values.data() + a * attribute.rowBytes();
      interpolateRow(attribute, a, b, fraction, row);
    }
  }

  // --- the result

  CollapsedPatch finish() {
    std::vector<std::uint32_t> cells;
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t i = 0; i < patch_.cells.size(); ++i) {
      if (!complex_.isDead(i)) cells.push_back(i);
    }
    std::vector<std::uint32_t> number(patch_.vertices.size(), model::kNoIndex);
    for (std::uint32_t i = 0; i < patch_.vertexCount(); ++i) {
      if (!complex_.isUsed(i) && holds_[i] != Hold::Place) continue;
      number[i] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(i);
    }
    std::vector<std::uint32_t> vertexOf(patch_.vertices.size());
    for (std::uint32_t i = 0; i < vertexOf.size(); ++i) vertexOf[i] = number[rootOf(i)];
    patch_.cells.assign(complex_.cells().begin(), complex_.cells().end());
    patch_.samples = samples_.take();
    selectFrom(patch_, vertices, cells);
    return {std::move(patch_), std::move(vertexOf), std::move(done_)};
  }

  std::uint32_t rootOf(std::uint32_t vertex) {
    while (joinedTo_[vertex] != vertex) {
      vertex = joinedTo_[vertex] = joinedTo_[joinedTo_[vertex]];
    }
    return vertex;
  }

  struct Shared {
    std::uint32_t vertex;
    Eigen::Vector4d normal;  // the sum over the cells of an edge
  };

  Patch patch_;
  const CollapseOptions& options_;
  CellComplex complex_;
  std::vector<Hold> holds_;
  SliceTopology topology_;  // knows vertices with a whole link and no cap
  ValueBorders borders_;
  NearSamples samples_;
  std::vector<Eigen::Vector4d> normals_;  // the sum of normals of the cells around each vertex
  std::vector<double> areas_;             // and of their lengths
  std::vector<std::uint32_t> versions_;
  std::vector<std::uint32_t> joinedTo_;
  std::vector<Collapse> done_;
  std::vector<Candidate> queue_;
  bool isHeap_ = false;
  std::vector<Shared> shared_;
};

}  // namespace

CollapsedPatch collapsed(Patch patch, const CollapseOptions& options) {
  return PatchCollapser(std::move(patch), options).run();
}

}  // namespace t4d::edit
