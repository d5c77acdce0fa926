#include "measure/slice_bound.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>

#include "measure/seen_part.h"
#include "measure/space_time_tetrahedron.h"
#include "model/box_tree.h"
#include "model/parallel.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::Bounds4;
using model::Cell;
using model::Point3;
using model::Point4;

using CellCorners = std::array<Point4, 4>;
using Tetrahedron = SpaceTimeTetrahedron;

using Neighbours = std::array<std::uint32_t, 4>;

/// A cell is split into no more pieces than this, and so many for each tetrahedron near to it.
constexpr std::size_t kMostPieces = 64;
constexpr std::size_t kPiecesPerTetrahedron = 4;

/// And no more often than this one after another: pieces of a hundredth of its size.
constexpr int kDeepestSplit = 20;

/// Tetrahedra whose slices are turned by more than this against those of a cell are no cover of it.
constexpr double kLeastCosine = 0.1;

/// A part that is moved before it is seen may go so far across the direction of view, and then be
/// so far along it: together the distance.
constexpr double kMostAcross = 0.5;
constexpr double kMostAlong = 0.866;

/// A cell with a point farther than this part of the distance is not split: pieces would have to
/// follow the borders of tetrahedra closely, and be many.
constexpr double kEasy = 0.95;

CellCorners cornersIn(const CellSet& set, const Cell& cell) {
  return {set.vertices[cell[0]], set.vertices[cell[1]], set.vertices[cell[2]],
          set.vertices[cell[3]]};
}

double volumeOf(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Whether a point lies inside a tetrahedron and not near its border.
bool isWellInside(const Point3& point, const std::array<Point3, 4>& corners) {
  constexpr double kMargin = 1e-6;
  const double all = volumeOf(corners[0], corners[1], corners[2], corners[3]);
  for (int k = 0; k < 4; ++k) {
    auto moved = corners;
    moved[k] = point;
    if (!(volumeOf(moved[0], moved[1], moved[2], moved[3]) / all > kMargin)) return false;
  }
  return true;
}

struct Facet {
  std::array<std::uint32_t, 3> vertices;  // increasing
  std::uint32_t tetrahedron;
  std::uint32_t corner;

  bool operator<(const Facet& other) const { return vertices < other.vertices; }
};

std::vector<Tetrahedron> tetrahedraOf(const CellSet& set) {
  std::vector<Tetrahedron> all;
  for (const Cell& cell : set.cells) {
    if (!isAtOneTime(cornersIn(set, cell))) all.emplace_back(cornersIn(set, cell));
  }
  return all;
}

std::vector<Neighbours> neighboursOf(const CellSet& set) {
  std::vector<Facet> facets;
  std::uint32_t number = 0;
  for (const Cell& cell : set.cells) {
    if (isAtOneTime(cornersIn(set, cell))) continue;
    for (std::uint32_t k = 0; k < 4; ++k) {
      Facet& facet = facets.emplace_back(
          Facet{{cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]}, number, k});
      std::ranges::sort(facet.vertices);
    }
    ++number;
  }
  model::sort(facets.begin(), facets.end());
  std::vector<Neighbours> all(number,
                              {model::kNoIndex, model::kNoIndex, model::kNoIndex, model::kNoIndex});
  for (std::size_t i = 0; i + 1 < facets.size(); ++i) {
    const Facet& one = facets[i];
    const Facet& next = facets[i + 1];
    if (one.vertices != next.vertices) continue;
    all[one.tetrahedron][one.corner] = next.tetrahedron;
    all[next.tetrahedron][next.corner] = one.tetrahedron;
  }
  return all;
}

std::vector<Bounds4> boundsOfAll(const std::vector<Tetrahedron>& all) {
  std::vector<Bounds4> bounds;
  bounds.reserve(all.size());
  for (const Tetrahedron& one : all) bounds.push_back(one.bounds);
  return bounds;
}

}  // namespace

/// The tetrahedra of a set that are in slices, and a tree over them.
class SliceBound::Tetrahedra {
 public:
  explicit Tetrahedra(const CellSet& set)
      : all_(tetrahedraOf(set)), neighbours_(neighboursOf(set)), tree_(boundsOfAll(all_)) {}

  const Tetrahedron& operator[](std::uint32_t i) const { return all_[i]; }
  /// The neighbours across from its corners.
  const Neighbours& neighbours(std::uint32_t i) const { return neighbours_[i]; }
  std::size_t size() const { return all_.size(); }

  /// Whether a point is within a distance of one of them at its own time.
  bool isNear(const Point4& point, std::uint32_t i, double distance) const {
    return all_[i].squaredDistance(point, distance * distance) <= distance * distance;
  }
  bool isNearToSome(const Point4& point, double distance) const {
    return tree_.anyOverlapping(model::widened({point, point}, distance),
                                [&](std::uint32_t i) { return isNear(point, i, distance); });
  }
  bool areNear(std::uint32_t i, const Bounds4& box, double distance) const {
    return model::overlap(tree_[i], model::widened(box, distance));
  }
  /// Finds the tetrahedra whose bounds are near to a box.
  void find(const Bounds4& box, double distance, std::vector<std::uint32_t>& found) const {
    found.clear();
    tree_.visitOverlapping(model::widened(box, distance),
                           [&](std::uint32_t i) { found.push_back(i); });
  }

 private:
  std::vector<Tetrahedron> all_;
  std::vector<Neighbours> neighbours_;
  model::BoxTree<4> tree_;
};

/// Proves that cells are near; reuses its buffers.
class SliceBound::Proof {
 public:
  Proof(const Tetrahedra& to, double distance)
      : to_(to), distance_(distance), isCover_(to.size(), 0) {}

  bool prove(const CellCorners& corners) {
    const Tetrahedron cell(corners);
    std::vector<std::uint32_t> near;
    to_.find(cell.bounds, distance_, near);
    pieces_ = kMostPieces + kPiecesPerTetrahedron * near.size();
    return prove(cell, corners, near, 0);
  }

 private:
  /// The point on an edge where a part is split in two.
  struct Split {
    int i;
    int j;
    Point4 point;
  };

  /// Proves a part of a cell among those that may be near to it.
  bool prove(const Tetrahedron& cell, const CellCorners& part,
             const std::vector<std::uint32_t>& near, int depth) {
    if (near.empty()) return false;
    std::optional<double> end;  // of the one that is near to most corners
    int most = 0;
    for (const std::uint32_t one : near) {
      const int count = cornersNear(part, one);
      if (count == 4) return true;
      if (count <= most) continue;
      if (const auto its = endWithin(part, one)) {
        end = its;
        most = count;
      }
    }
    if (isCovered(cell, part, near)) return true;
    if (pieces_ == 0 || depth == kDeepestSplit) return false;
    if (depth == 0 && !hasEasySamples(part)) return false;
    --pieces_;
    const auto [i, j, point] = end ? splitAtTime(part, *end) : splitInHalf(cell, part, near);
    for (const int replaced : {i, j}) {
      CellCorners half = part;
      half[replaced] = point;
      const Bounds4 bounds = boundsOf(half);
      std::vector<std::uint32_t> nearHalf;
      for (const std::uint32_t one : near) {
        if (to_.areNear(one, bounds, distance_)) nearHalf.push_back(one);
      }
      if (!prove(cell, half, nearHalf, depth + 1)) return false;
    }
    return true;
  }

  /// The number of corners at times of a tetrahedron if it is near to all of these; else 0.
  int cornersNear(const CellCorners& part, std::uint32_t number) const {
    const Tetrahedron& one = to_[number];
    int count = 0;
    for (const Point4& corner : part) {
      if (corner[3] < one.timeBegin() || corner[3] > one.timeEnd()) continue;
      if (!to_.isNear(corner, number, distance_)) return 0;
      ++count;
    }
    return count;
  }

  /// The time, between those of the corners, at which a tetrahedron begins or ends.
  std::optional<double> endWithin(const CellCorners& part, std::uint32_t number) const {
    const Bounds4 bounds = boundsOf(part);
    for (const double time : {to_[number].timeBegin(), to_[number].timeEnd()}) {
      if (bounds.min[3] < time && time < bounds.max[3]) return time;
    }
    return std::nullopt;
  }

  /// Whether those near enough along the normal of the cell cover the part, seen along it; if not
  /// as it is, then moved a little within its hyperplane, each corner at its own time.
  bool isCovered(const Tetrahedron& cell, const CellCorners& part,
                 const std::vector<std::uint32_t>& near) {
    const View view(cell.normal.head<3>());
    if (covers(cell, view, part, near, distance_)) return true;
    constexpr int kMostMoves = 3;  // from one end, others may be met
    CellCorners moved = part;
    for (int i = 0; i < kMostMoves && moveInside(view, part, moved); ++i) {
      if (covers(cell, view, moved, near, kMostAlong * distance_)) return true;
    }
    return false;
  }

  /// Sets the ends of the cover that are seen in front of the part.
  bool covers(const Tetrahedron& cell, const View& view, const CellCorners& part,
              const std::vector<std::uint32_t>& near, double distance) {
    const SeenPart seen(view, part);
    ++cover_;
    ends_.clear();
    for (const std::uint32_t i : near) {
      if (isNearAlong(cell, view.direction(), seen, to_[i], distance)) isCover_[i] = cover_;
    }
    if (!coversAPoint(view, seen.corners(), near)) return false;
    for (const std::uint32_t i : near) {
      if (isCover_[i] == cover_) addEnds(view, seen, i);
    }
    return ends_.empty();
  }

  /// Moves a part behind the ends of the cover, unless a corner gets too far from where it was.
  bool moveInside(const View& view, const CellCorners& part, CellCorners& moved) const {
    constexpr std::size_t kMostEnds = 64;
    constexpr double kLeastInSpace = 1e-3;
    constexpr double kABitMore = 1 + 1e-6;
    if (ends_.empty() || ends_.size() > kMostEnds) return false;
    for (const End& end : ends_) {
      const Eigen::Vector2d across = end.normal.head<2>();
      const double size = across.norm();
      if (!(size > kLeastInSpace * end.normal.norm())) return false;
      for (Point4& corner : moved) {
        const double depth = end.normal.dot(view(corner) - end.point) / size;
        if (depth > 0) corner.head<3>() -= view.inSpace(kABitMore * depth / size * across);
      }
    }
    for (int i = 0; i < 4; ++i) {
      if ((moved[i] - part[i]).norm() > kMostAcross * distance_) return false;
    }
    return true;
  }

  /// Whether a tetrahedron faces the same way as the cell, and is near to the part of it where they
  /// are seen one behind the other.
  bool isNearAlong(const Tetrahedron& cell, const Point3& direction, const SeenPart& part,
                   const Tetrahedron& other, double distance) const {
    if (!(other.normal.head<3>().dot(direction) > kLeastCosine)) return false;
    const auto isWithin = [&](const Point4& corner) {
      return std::abs(cell.normal.dot(corner - cell.corners[0])) <= distance;
    };
    return std::ranges::all_of(other.corners, isWithin) || part.isNear(other, distance);
  }

  /// Whether a point of the part, as good as any, is seen before one of the cover.
  bool coversAPoint(const View& view, const std::array<Point3, 4>& seen,
                    const std::vector<std::uint32_t>& near) const {
    const Point3 point = 0.31 * seen[0] + 0.27 * seen[1] + 0.23 * seen[2] + 0.19 * seen[3];
    return std::ranges::any_of(near, [&](std::uint32_t i) {
      if (isCover_[i] != cover_) return false;
      const Tetrahedron& one = to_[i];
      if (point[2] < one.timeBegin() || point[2] > one.timeEnd()) return false;
      return isWellInside(point, {view(one.corners[0]), view(one.corners[1]), view(one.corners[2]),
                                  view(one.corners[3])});
    });
  }

  /// Adds the facets of a tetrahedron where the cover ends that are seen in front of the part.
  void addEnds(const View& view, const SeenPart& seen, std::uint32_t number) {
    const Tetrahedron& one = to_[number];
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t neighbour = to_.neighbours(number)[k];
      if (neighbour != model::kNoIndex && isCover_[neighbour] == cover_) continue;
      const std::array<Point3, 3> facet = {view(one.corners[(k + 1) % 4]),
                                           view(one.corners[(k + 2) % 4]),
                                           view(one.corners[(k + 3) % 4])};
      if (seen.isApartFrom(facet)) continue;
      Point3 normal = (facet[1] - facet[0]).cross(facet[2] - facet[0]);
      if (normal.dot(view(one.corners[k]) - facet[0]) > 0) normal = -normal;
      ends_.push_back({facet[0], normal});
    }
  }

  bool isEasy(const Point4& point) const { return to_.isNearToSome(point, kEasy * distance_); }

  /// Whether its corners and the middles of its edges, its sides and itself are easy.
  bool hasEasySamples(const CellCorners& cell) const {
    for (int which = 1; which < 16; ++which) {
      Point4 sum = Point4::Zero();
      int count = 0;
      for (int i = 0; i < 4; ++i) {
        if ((which >> i & 1) == 0) continue;
        sum += cell[i];
        ++count;
      }
      if (!isEasy(sum / count)) return false;
    }
    return true;
  }

  /// Splits a part on its longest edge across a time.
  static Split splitAtTime(const CellCorners& part, double time) {
    Split split{};
    double most = -1;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double length = (part[i] - part[j]).squaredNorm();
        if (!(part[i][3] < time && time < part[j][3] && length > most)) continue;
        most = length;
        const double fraction = (time - part[i][3]) / (part[j][3] - part[i][3]);
        split = {i, j, part[i] + fraction * (part[j] - part[i])};
      }
    }
    split.point[3] = time;
    return split;
  }

  /// Splits a part in the middle of the edge along which the heights over those that are too far to
  /// be a cover change most; if there are none, of the longest edge.
  Split splitInHalf(const Tetrahedron& cell, const CellCorners& part,
                    const std::vector<std::uint32_t>& near) const {
    const Point3 direction = cell.normal.head<3>();
    std::array<std::array<double, 4>, 4> changes{};
    for (const std::uint32_t i : near) {
      const Tetrahedron& one = to_[i];
      const double cosine = one.normal.head<3>().dot(direction);
      if (isCover_[i] == cover_ || !(cosine > kLeastCosine)) continue;
      for (int a = 0; a < 4; ++a) {
        for (int b = a + 1; b < 4; ++b) {
          changes[a][b] += std::abs(one.normal.dot(part[b] - part[a])) / cosine;
        }
      }
    }
    Split split{};
    std::pair<double, double> most(-1, -1);
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        const std::pair its(changes[a][b], (part[a] - part[b]).squaredNorm());
        if (its <= most) continue;
        most = its;
        split = {a, b, (part[a] + part[b]) / 2};
      }
    }
    return split;
  }

  /// A facet where the cover ends.
  struct End {
    Point3 point;
    Point3 normal;  // away from the cover
  };

  const Tetrahedra& to_;
  double distance_;
  std::size_t pieces_ = 0;              // that may still be made
  std::vector<std::uint64_t> isCover_;  // the number of the cover that each was part of last
  std::uint64_t cover_ = 0;
  std::vector<End> ends_;
};

SliceBound::SliceBound(const CellSet& to) : to_(std::make_unique<const Tetrahedra>(to)) {}
SliceBound::~SliceBound() = default;
SliceBound::SliceBound(SliceBound&&) noexcept = default;
SliceBound& SliceBound::operator=(SliceBound&&) noexcept = default;

bool SliceBound::isNear(const Point4& point, double distance) const {
  return to_->isNearToSome(point, distance);
}

std::vector<std::uint32_t> SliceBound::notProvedNear(const CellSet& cells, double distance) const {
  model::PerThread<Proof> proofs([&] { return Proof(*to_, distance); });
  std::vector<char> isProved(cells.cells.size(), 1);
  model::forRanges(0, cells.cells.size(), 64, [&](std::size_t begin, std::size_t end) {
    Proof& proof = proofs.local();
    for (std::size_t i = begin; i < end; ++i) {
      if (isAtOneTime(cornersIn(cells, cells.cells[i]))) continue;
      isProved[i] = proof.prove(cornersIn(cells, cells.cells[i])) ? 1 : 0;
    }
  });
  std::vector<std::uint32_t> unproved;
  for (std::uint32_t i = 0; i < isProved.size(); ++i) {
    if (isProved[i] == 0) unproved.push_back(i);
  }
  return unproved;
}

}  // namespace t4d::measure
