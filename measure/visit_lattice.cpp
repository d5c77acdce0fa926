#include "measure/visit_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "measure/exact_signs.h"
#include "model/parallel.h"
#include "model/progress.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

// Triangles that are met with lines together.
constexpr std::size_t kTogether = 4096;

/// The sign of det[b - a, p - a] for p = (u, v) moved by symbolic amounts, first in u or first in
/// v.
int sideOf(const Point2& a, const Point2& b, const Point2& p, bool uFirst) {
  const int sign = orientation(a, b, p);
  if (sign != 0) return sign;
  const int byU = a.y() > b.y() ? 1 : a.y() < b.y() ? -1 : 0;
  const int byV = b.x() > a.x() ? 1 : b.x() < a.x() ? -1 : 0;
  if (uFirst) return byU != 0 ? byU : byV;
  return byV != 0 ? byV : byU;
}

/// A triangle and the lattice lines along an axis.
class LineTriangle {
 public:
  LineTriangle(const std::array<Point3, 3>& corners, int axis) : corners_(corners), axis_(axis) {
    for (int i = 0; i < 3; ++i) flat_[i] = acrossAxis(corners[i], axis);
    facing_ = orientation(flat_[0], flat_[1], flat_[2]);
  }

  /// The sign of the normal along the axis; 0 if no line goes through the triangle.
  int facing() const { return facing_; }

  bool covers(const Point2& line) const {
    // The order of the moves is x, y, z: of the plane (z, x) the second coordinate comes first.
    const bool uFirst = axis_ != 1;
    for (int i = 0; i < 3; ++i) {
      if (sideOf(flat_[i], flat_[(i + 1) % 3], line, uFirst) != facing_) return false;
    }
    return true;
  }

  /// The least and the largest second coordinate of the lines with this first one that may go
  /// through the triangle, up to rounding.
  std::pair<double, double> rangeAt(double u) const {
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (int i = 0; i < 3; ++i) {
      const Point2& a = flat_[i];
      const Point2& b = flat_[(i + 1) % 3];
      if (!(std::min(a.x(), b.x()) <= u && u <= std::max(a.x(), b.x()))) continue;
      const double part = a.x() == b.x() ? 0 : (u - a.x()) / (b.x() - a.x());
      const double v = a.y() + part * (b.y() - a.y());
      least = std::min({least, v, a.x() == b.x() ? b.y() : v});
      most = std::max({most, v, a.x() == b.x() ? b.y() : v});
    }
    return {least, most};
  }

  /// Whether a point of a line that goes through the triangle comes after it.
  bool isBefore(const Point3& point) const {
    return movedOrientation(corners_[0], corners_[1], corners_[2], point) == facing_;
  }

  /// The place where a line goes through the triangle, up to rounding.
  double placeOn(const Point2& line) const {
    double sum = 0;
    double weights = 0;
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (int i = 0; i < 3; ++i) {
      const Point2 u = flat_[(i + 1) % 3] - line;
      const Point2 v = flat_[(i + 2) % 3] - line;
      const double weight = u.x() * v.y() - u.y() * v.x();
      const double at = corners_[i][axis_];
      sum += weight * (at - corners_[0][axis_]);
      weights += weight;
      least = std::min(least, at);
      most = std::max(most, at);
    }
    const double place = corners_[0][axis_] + sum / weights;
    return std::isfinite(place) ? std::clamp(place, least, most) : 0.5 * (least + most);
  }

 private:
  std::array<Point3, 3> corners_;
  std::array<Point2, 3> flat_;
  int axis_;
  int facing_;
};

std::array<Point3, 3> cornersOf(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

}  // namespace

/// A crossing of a triangle and a lattice edge.
struct VisitLattice::Event {
  std::uint64_t key;  // of the edge's lower end
  std::uint32_t triangle;
  float facing;  // the sign of its normal along the edge
  double place;

  /// The order in which they are met.
  friend bool operator<(const Event& a, const Event& b) {
    if (a.key != b.key) return a.key < b.key;
    return a.place != b.place ? a.place < b.place : a.triangle < b.triangle;
  }
};

/// An edge with one end inside.
struct VisitLattice::Edge {
  std::uint64_t key;
  int low;  // the winding number at its lower end
  bool insideIsLow;
};

std::vector<VisitLattice::Event> VisitLattice::eventsAlong(const TriangleMesh& surface, int axis,
                                                           std::span<const Edge> wanted,
                                                           const model::Progress& progress) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const std::size_t groups = (surface.triangles.size() + kTogether - 1) / kTogether;
  std::vector<std::vector<Event>> found(groups);
  whole_ = model::forEach(groups, progress, [&](std::size_t group) {
    const std::size_t end = std::min((group + 1) * kTogether, surface.triangles.size());
    for (std::size_t i = group * kTogether; i < end; ++i) {
      const std::array<Point3, 3> corners = cornersOf(surface, i);
      const Point3 least = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
      const Point3 most = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
      const std::uint32_t uBegin = lattice_.firstFrom(u, least[u]);
      const std::uint32_t uEnd = lattice_.firstAfter(u, most[u]);
      const std::uint32_t vBegin = lattice_.firstFrom(v, least[v]);
      const std::uint32_t vEnd = lattice_.firstAfter(v, most[v]);
      if (uBegin == uEnd || vBegin == vEnd) continue;
      const LineTriangle triangle(corners, axis);
      if (triangle.facing() == 0) continue;
      const std::uint32_t from = lattice_.firstFrom(axis, least[axis]);
      const std::uint32_t to = lattice_.firstAfter(axis, most[axis]);
      for (std::uint32_t j = uBegin; j < uEnd; ++j) {
        // One line farther to either side, since the range is rounded.
        const auto [lowest, highest] = triangle.rangeAt(lattice_.at[u][j]);
        const std::uint32_t kBegin = std::max(vBegin + 1, lattice_.firstFrom(v, lowest)) - 1;
        const std::uint32_t kEnd = std::min(vEnd - 1, lattice_.firstAfter(v, highest)) + 1;
        for (std::uint32_t k = kBegin; k < kEnd; ++k) {
          const Point2 line(lattice_.at[u][j], lattice_.at[v][k]);
          if (!triangle.covers(line)) continue;
          Point3 point;
          point[u] = line[0];
          point[v] = line[1];
          // The first lattice point after the crossing.
          std::uint32_t low = from;
          std::uint32_t high = to;
          while (low < high) {
            const std::uint32_t middle = (low + high) / 2;
            point[axis] = lattice_.at[axis][middle];
            if (triangle.isBefore(point)) {
              high = middle;
            } else {
              low = middle + 1;
            }
          }
          LatticeIndex index;
          index[axis] = low - 1;
          index[u] = j;
          index[v] = k;
          const std::uint64_t key = keyOf(index);
          if (!wanted.empty()) {
            const auto at = std::ranges::lower_bound(wanted, key, {}, &Edge::key);
            if (at == wanted.end() || at->key != key) continue;
          }
          found[group].push_back({key, static_cast<std::uint32_t>(i),
                                  static_cast<float>(triangle.facing()), triangle.placeOn(line)});
        }
      }
    }
  });
  std::vector<Event> events;
  if (!whole_) return events;
  std::size_t count = 0;
  for (const auto& some : found) count += some.size();
  events.reserve(count);
  for (auto& some : found) {
    events.insert(events.end(), some.begin(), some.end());
    some = {};
  }
  model::sort(events.begin(), events.end());
  return events;
}

void VisitLattice::setColumns(const std::vector<Event>& events) {
  columnEnds_.assign(lattice_.at[0].size() * lattice_.at[1].size(), 0);
  std::size_t column = 0;
  int winding = 0;
  for (std::size_t i = 0; i < events.size();) {
    const LatticeIndex index = indexOf(events[i].key);
    const std::size_t own = index[0] * lattice_.at[1].size() + index[1];
    for (; column < own; ++column) {
      columnEnds_[column] = runs_.size();
      winding = 0;
    }
    const int before = winding;
    const std::uint64_t key = events[i].key;
    // The surface faces down where the line enters.
    for (; i < events.size() && events[i].key == key; ++i) {
      winding -= static_cast<int>(events[i].facing);
    }
    if (winding != before) runs_.push_back({index[2] + 1, winding});
  }
  for (; column < columnEnds_.size(); ++column) columnEnds_[column] = runs_.size();
}

std::span<const VisitLattice::Run> VisitLattice::column(std::uint32_t x, std::uint32_t y) const {
  const std::size_t number = x * lattice_.at[1].size() + y;
  const std::uint64_t begin = number == 0 ? 0 : columnEnds_[number - 1];
  return std::span(runs_).subspan(begin, columnEnds_[number] - begin);
}

bool VisitLattice::allInside(const LatticeIndex& low, const LatticeIndex& high) const {
  for (std::uint32_t x = low[0]; x <= high[0]; ++x) {
    for (std::uint32_t y = low[1]; y <= high[1]; ++y) {
      const auto runs = column(x, y);
      auto after = std::ranges::upper_bound(runs, low[2], {}, &Run::from);
      if (after == runs.begin() || (after - 1)->winding < 1) return false;
      for (; after != runs.end() && after->from <= high[2]; ++after) {
        if (after->winding < 1) return false;
      }
    }
  }
  return true;
}

int VisitLattice::winding(const LatticeIndex& point) const {
  const auto runs = column(point[0], point[1]);
  const auto after = std::ranges::upper_bound(runs, point[2], {}, &Run::from);
  return after == runs.begin() ? 0 : (after - 1)->winding;
}

std::vector<VisitLattice::Edge> VisitLattice::edgesAlong(int axis) const {
  std::vector<Edge> edges;
  const auto add = [&](const LatticeIndex& index, int low, int high) {
    if ((low >= 1) != (high >= 1)) edges.push_back({keyOf(index), low, low >= 1});
  };
  const auto endX = static_cast<std::uint32_t>(lattice_.at[0].size());
  const auto endY = static_cast<std::uint32_t>(lattice_.at[1].size());
  const auto endZ = static_cast<std::uint32_t>(lattice_.at[2].size());
  for (std::uint32_t x = 0; x < endX; ++x) {
    for (std::uint32_t y = 0; y < endY; ++y) {
      const auto own = column(x, y);
      if (axis == 2) {
        int low = 0;
        for (const Run& run : own) {
          add({x, y, run.from - 1}, low, run.winding);
          low = run.winding;
        }
        continue;
      }
      if ((axis == 0 ? x + 1 == endX : y + 1 == endY)) continue;
      const auto next = axis == 0 ? column(x + 1, y) : column(x, y + 1);
      // Goes up both columns; between two changes nothing changes.
      std::size_t i = 0;
      std::size_t j = 0;
      int low = 0;
      int high = 0;
      while (i < own.size() || j < next.size()) {
        const std::uint32_t ownFrom = i < own.size() ? own[i].from : endZ;
        const std::uint32_t nextFrom = j < next.size() ? next[j].from : endZ;
        const std::uint32_t from = std::min(ownFrom, nextFrom);
        if (ownFrom == from) low = own[i++].winding;
        if (nextFrom == from) high = next[j++].winding;
        const std::uint32_t end =
            std::min(i < own.size() ? own[i].from : endZ, j < next.size() ? next[j].from : endZ);
        if ((low >= 1) == (high >= 1)) continue;
        for (std::uint32_t z = from; z < end; ++z) add({x, y, z}, low, high);
      }
    }
  }
  return edges;
}

std::vector<LatticeCrossing> VisitLattice::crossingsOf(const TriangleMesh& surface, int axis,
                                                       std::span<const Edge> edges,
                                                       std::span<const Event> events) const {
  std::vector<LatticeCrossing> crossings(edges.size());
  model::forEach(edges.size(), [&](std::size_t e) {
    const Edge& edge = edges[e];
    LatticeCrossing& crossing = crossings[e];
    crossing.key = edge.key;
    crossing.fraction = 0.5;
    crossing.normal = Point3::Unit(axis) * (edge.insideIsLow ? 1 : -1);
    // The outermost one: the last if the inner end is the lower one, else the first.
    int winding = edge.low;
    const Event* chosen = nullptr;
    for (auto event = std::ranges::lower_bound(events, edge.key, {}, &Event::key);
         event != events.end() && event->key == edge.key; ++event) {
      const bool before = winding >= 1;
      winding -= static_cast<int>(event->facing);
      if ((winding >= 1) == before || before != edge.insideIsLow) continue;
      if (chosen == nullptr || edge.insideIsLow) chosen = &*event;
    }
    if (chosen == nullptr) return;
    const std::uint32_t index = indexOf(edge.key)[axis];
    const double low = lattice_.at[axis][index];
    const double high = lattice_.at[axis][index + 1];
    crossing.fraction = std::clamp((chosen->place - low) / (high - low), 0.0, 1.0);
    const auto [a, b, c] = cornersOf(surface, chosen->triangle);
    const Point3 normal = ((b - a) / lattice_.spacing).cross((c - a) / lattice_.spacing);
    const double length = normal.norm();
    if (length > 0 && std::isfinite(length)) crossing.normal = normal / length;
  });
  return crossings;
}

VisitLattice::VisitLattice(const TriangleMesh& surface, SpaceLattice lattice,
                           const model::Progress& progress, bool withCrossings)
    : lattice_(std::move(lattice)) {
  const auto third = [&](int which) {
    return model::partOf(progress, which / 3.0, (which + 1) / 3.0);
  };
  const std::vector<Event> upward =
      eventsAlong(surface, 2, {}, withCrossings ? third(0) : progress);
  if (!whole_) return;
  setColumns(upward);
  if (!withCrossings) return;
  crossings_[2] = crossingsOf(surface, 2, edgesAlong(2), upward);
  for (int axis = 0; axis < 2; ++axis) {
    const std::vector<Edge> edges = edgesAlong(axis);
    if (edges.empty()) continue;
    const std::vector<Event> events = eventsAlong(surface, axis, edges, third(1 + axis));
    if (!whole_) return;
    crossings_[axis] = crossingsOf(surface, axis, edges, events);
  }
}

namespace {

/// Counts of the work to do.
struct LatticeWork {
  double rows = 0;       ///< planes of lines that triangles meet
  double crossings = 0;  ///< of lines and triangles
  /// Crossings of the surface that is made. A silhouette may have many layers within it; a surface
  /// of more than four times the area of its bounds is rare.
  double outer = 0;
};

LatticeWork workOf(const TriangleMesh& surface, const SpaceLattice& lattice) {
  LatticeWork work = model::reduce<LatticeWork>(
      surface.triangles.size(), kTogether,
      [&](std::size_t begin, std::size_t end, LatticeWork sum) {
        for (std::size_t i = begin; i < end; ++i) {
          const auto [a, b, c] = cornersOf(surface, i);
          const Point3 u = (b - a) / lattice.spacing;
          const Point3 v = (c - a) / lattice.spacing;
          sum.crossings += u.cross(v).lpNorm<1>() / 2;
          sum.rows += (u.cwiseMax(v).cwiseMax(0) - u.cwiseMin(v).cwiseMin(0)).sum();
        }
        return sum;
      },
      [](const LatticeWork& a, const LatticeWork& b) {
        return LatticeWork{.rows = a.rows + b.rows, .crossings = a.crossings + b.crossings};
      });
  for (int axis = 0; axis < 3; ++axis) {
    work.outer += 8.0 * static_cast<double>(lattice.at[(axis + 1) % 3].size()) *
                  static_cast<double>(lattice.at[(axis + 2) % 3].size());
  }
  work.outer = std::min(work.outer, work.crossings);
  return work;
}

}  // namespace

double VisitLattice::estimatedBytes(const TriangleMesh& surface, const SpaceLattice& lattice) {
  const LatticeWork work = workOf(surface, lattice);
  // All crossings of the lines in one direction are sorted, and take twice that while they are
  // collected.
  constexpr double kBytesACrossing = 48;
  // The surface has about as many cubes and four triangles for each of its crossings, and they are
  // searched for self-intersections.
  constexpr double kBytesOfSurface = 752;
  return kBytesACrossing * work.crossings + kBytesOfSurface * work.outer +
         8.0 * static_cast<double>(lattice.at[0].size()) *
             static_cast<double>(lattice.at[1].size());
}

double VisitLattice::estimatedSeconds(const TriangleMesh& surface, const SpaceLattice& lattice) {
  const LatticeWork work = workOf(surface, lattice);
  constexpr double kARow = 1e-7;
  constexpr double kACrossing = 1e-6;
  constexpr double kOfSurface = 1e-5;
  return kARow * work.rows + kACrossing * work.crossings + kOfSurface * work.outer;
}

}  // namespace t4d::measure
