#include "t4d/measure/offset_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "t4d/measure/parallel_for.h"
#include "t4d/measure/triangle_tree.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

constexpr double kHalfDiagonal = std::numbers::sqrt3 / 2;
/// What vertices are moved along the longest edge.
constexpr double kMoved = std::numbers::sqrt3 * kOffsetMargin;

double levelOf(double reach, double spacing) {
  return std::hypot(reach + kMoved * spacing, kHalfDiagonal * spacing);
}

/// The longest edge of pieces of triangles, in units: some voxels.
constexpr double kLongest = 16;

/// The tetrahedra about the diagonal of a cube, whose corners have the numbers x + 2 y + 4 z, all
/// with det[b - a, c - a, d - a] > 0. Those of neighbours fit.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 2, 7, 3}, {0, 1, 7, 5}, {0, 4, 7, 6}}};

/// The even orders of four corners with each of them first.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kFirst = {
    {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}}};
/// Those with corners 0 and 1, 2 or 3 in front, and those with the other two in front.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kPairs = {
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {2, 3, 0, 1}, {3, 1, 0, 2}, {1, 2, 0, 3}}};

LatticeIndex cornerOf(const LatticeIndex& low, unsigned corner) {
  return {low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2 & 1)};
}

class Offset {
 public:
  Offset(const TriangleMesh& surface, const VisitLattice& visits, double reach)
      : visits_(visits),
        lattice_(visits.lattice()),
        // A power of two, which brings the spacing near 1: squares neither over- nor underflow.
        unit_(std::ldexp(1.0, -std::ilogb(lattice_.spacing))),
        level_(levelOf(reach, lattice_.spacing) * unit_),
        tree_(scaled(surface)) {}

  TriangleMesh make(const model::Progress& progress) {
    findCubes(partOf(progress, 0, 0.5));
    findValues(partOf(progress, 0.5, 0.9));
    findMixed(partOf(progress, 0.9, 1));
    setVertices();
    setTriangles();
    return std::move(mesh_);
  }

 private:
  using Cube = std::array<std::uint32_t, 8>;  // its corners in points_

  /// The surface in units, with long triangles cut in pieces: boxes about slivers that lie across
  /// the axes have everything in them.
  TriangleMesh scaled(const TriangleMesh& surface) const {
    TriangleMesh pieces;
    for (const Point3& vertex : surface.vertices) pieces.vertices.push_back(vertex * unit_);
    std::vector<model::Triangle> left;
    for (const model::Triangle& triangle : surface.triangles) {
      left.push_back(triangle);
      while (!left.empty()) {
        const model::Triangle piece = left.back();
        left.pop_back();
        const auto length = [&](std::size_t k) {
          return (pieces.vertices[piece[k]] - pieces.vertices[piece[(k + 1) % 3]]).squaredNorm();
        };
        std::size_t longest = 0;
        for (const std::size_t k : {1U, 2U}) {
          if (length(k) > length(longest)) longest = k;
        }
        if (!(length(longest) > kLongest * kLongest)) {
          pieces.triangles.push_back(piece);
          continue;
        }
        const std::uint32_t a = piece[longest];
        const std::uint32_t b = piece[(longest + 1) % 3];
        const std::uint32_t c = piece[(longest + 2) % 3];
        const auto middle = static_cast<std::uint32_t>(pieces.vertices.size());
        pieces.vertices.emplace_back((pieces.vertices[a] + pieces.vertices[b]) / 2);
        left.push_back({a, middle, c});
        left.push_back({middle, b, c});
      }
    }
    return pieces;
  }

  Point3 placeOf(const LatticeIndex& point) const {
    return {lattice_.at[0][point[0]], lattice_.at[1][point[1]], lattice_.at[2][point[2]]};
  }

  /// Whether a block of cubes may meet the surface.
  bool mayMeet(const LatticeIndex& low, std::uint32_t size) const {
    constexpr std::uint32_t kSmall = 8;  // so that its points are looked at in no time
    constexpr double kSlack = 1 + 1e-6;  // for rounding
    LatticeIndex high;
    for (int axis = 0; axis < 3; ++axis) {
      const auto last = static_cast<std::uint32_t>(lattice_.at[axis].size() - 1);
      high[axis] = std::min(low[axis] + size, last);
    }
    if (size <= kSmall && visits_.allInside(low, high)) return false;
    const Point3 from = placeOf(low) * unit_;
    const Point3 to = placeOf(high) * unit_;
    const double half = kSlack * (to - from).norm() / 2;
    const double distance = tree_.nearest((from + to) / 2, level_ + half).distance;
    return distance < level_ + half && distance > level_ - half;
  }

  /// Where corners on both sides differ, one is no farther than the level from the set's surface
  /// and the other farther: an edge is no longer than sqrt(3) spacings, and the level half of that
  /// at least, so the set's surface does not pass between points that are both farther away.
  void findCubes(const model::Progress& progress) {
    std::uint32_t size = 1;
    for (const auto& at : lattice_.at) {
      size = std::max(size, std::bit_ceil(static_cast<std::uint32_t>(at.size() - 1)));
    }
    cubes_ = {0};
    for (double done = 0;; size /= 2) {
      std::vector<std::uint8_t> meets(cubes_.size());
      // Half of the work is that of the last round.
      const double now = size == 1 ? 1 : (1 + done) / 2;
      parallelFor(cubes_.size(), partOf(progress, done, now),
                  [&](std::size_t i) { meets[i] = mayMeet(indexOf(cubes_[i]), size) ? 1 : 0; });
      done = size == 2 ? 0.5 : 0.5 * done;
      std::vector<std::uint64_t> next;
      for (std::size_t i = 0; i < cubes_.size(); ++i) {
        if (meets[i] == 0) continue;
        if (size == 1) {
          next.push_back(cubes_[i]);
          continue;
        }
        const LatticeIndex low = indexOf(cubes_[i]);
        for (unsigned corner = 0; corner < 8; ++corner) {
          LatticeIndex child = low;
          bool exists = true;
          for (int axis = 0; axis < 3; ++axis) {
            child[axis] += (corner >> axis & 1) * size / 2;
            exists = exists && child[axis] + 1 < lattice_.at[axis].size();
          }
          if (exists) next.push_back(keyOf(child));
        }
      }
      cubes_ = std::move(next);
      if (size == 1) break;
    }
    std::ranges::sort(cubes_);
  }

  void findValues(const model::Progress& progress) {
    points_.reserve(8 * cubes_.size());
    for (const std::uint64_t cube : cubes_) {
      for (unsigned corner = 0; corner < 8; ++corner) {
        points_.push_back(keyOf(cornerOf(indexOf(cube), corner)));
      }
    }
    std::ranges::sort(points_);
    points_.erase(std::ranges::unique(points_).begin(), points_.end());
    points_.shrink_to_fit();
    values_.resize(points_.size());
    const double most = level_ + 2 * std::numbers::sqrt3 * lattice_.spacing * unit_;
    parallelFor(points_.size(), progress, [&](std::size_t i) {
      const LatticeIndex point = indexOf(points_[i]);
      if (visits_.isInside(point)) return;
      const double distance = tree_.nearest(placeOf(point) * unit_, most).distance;
      values_[i] = distance * distance;
    });
  }

  bool isInside(std::uint32_t point) const { return values_[point] <= level_ * level_; }

  void findMixed(const model::Progress& progress) {
    std::vector<Cube> all(cubes_.size());
    parallelFor(cubes_.size(), progress, [&](std::size_t i) {
      for (unsigned corner = 0; corner < 8; ++corner) {
        const std::uint64_t key = keyOf(cornerOf(indexOf(cubes_[i]), corner));
        all[i][corner] =
            static_cast<std::uint32_t>(std::ranges::lower_bound(points_, key) - points_.begin());
      }
    });
    std::erase_if(all, [&](const Cube& cube) {
      return std::ranges::all_of(cube, [&](auto point) { return isInside(point); }) ||
             std::ranges::none_of(cube, [&](auto point) { return isInside(point); });
    });
    mixed_ = std::move(all);
    cubes_ = {};
  }

  template <class Visit>
  void forEachCut(const Cube& cube, const Visit& visit) const {
    for (unsigned low = 0; low < 8; ++low) {
      for (unsigned high = low + 1; high < 8; ++high) {
        if ((low & high) != low || isInside(cube[low]) == isInside(cube[high])) continue;
        visit(cube[low], cube[high], high ^ low);
      }
    }
  }

  /// The number of the vertex on the edge from a point in a direction, one of seven.
  std::uint32_t vertexOn(std::uint32_t low, unsigned direction) const {
    const unsigned before = cuts_[low] & ((1U << direction) - 1);
    return firsts_[low] + static_cast<std::uint32_t>(std::popcount(before));
  }

  void setVertices() {
    cuts_.assign(points_.size(), 0);
    for (const Cube& cube : mixed_) {
      forEachCut(cube, [&](std::uint32_t low, std::uint32_t /*high*/, unsigned direction) {
        cuts_[low] = static_cast<std::uint8_t>(cuts_[low] | 1U << direction);
      });
    }
    std::uint32_t count = 0;
    firsts_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      firsts_[i] = count;
      count += static_cast<std::uint32_t>(std::popcount(cuts_[i]));
    }
    mesh_.vertices.resize(count);
    for (const Cube& cube : mixed_) {
      forEachCut(cube, [&](std::uint32_t low, std::uint32_t high, unsigned direction) {
        const std::uint32_t in = isInside(low) ? low : high;
        const std::uint32_t out = isInside(low) ? high : low;
        const double part = (level_ * level_ - values_[in]) / (values_[out] - values_[in]);
        const Point3 from = placeOf(indexOf(points_[in]));
        const Point3 to = placeOf(indexOf(points_[out]));
        mesh_.vertices[vertexOn(low, direction)] =
            from + std::clamp(part, kOffsetMargin, 1 - kOffsetMargin) * (to - from);
      });
    }
  }

  void setTriangles() {
    for (const Cube& cube : mixed_) {
      for (const auto& tetrahedron : kTetrahedra) addTriangles(cube, tetrahedron);
    }
  }

  void addTriangles(const Cube& cube, const std::array<std::uint8_t, 4>& tetrahedron) {
    unsigned inside = 0;
    for (unsigned i = 0; i < 4; ++i) {
      if (isInside(cube[tetrahedron[i]])) inside |= 1U << i;
    }
    const auto on = [&](std::uint8_t a, std::uint8_t b) {
      const unsigned p = tetrahedron[a];
      const unsigned q = tetrahedron[b];
      return vertexOn(cube[p & q], p ^ q);
    };
    const int count = std::popcount(inside);
    if (count == 1 || count == 3) {
      const auto& [i, j, k, l] =
          kFirst[static_cast<std::size_t>(std::countr_zero(count == 1 ? inside : ~inside))];
      mesh_.triangles.push_back(count == 1 ? model::Triangle{on(i, j), on(i, k), on(i, l)}
                                           : model::Triangle{on(i, j), on(i, l), on(i, k)});
    } else if (count == 2) {
      const auto& [i, j, k, l] = *std::ranges::find_if(
          kPairs, [&](const auto& pair) { return inside == (1U << pair[0] | 1U << pair[1]); });
      mesh_.triangles.push_back({on(i, k), on(i, l), on(j, l)});
      mesh_.triangles.push_back({on(i, k), on(j, l), on(j, k)});
    }
  }

  const VisitLattice& visits_;
  const SpaceLattice& lattice_;
  double unit_;
  double level_;                       // in units
  TriangleTree tree_;                  // in units
  std::vector<std::uint64_t> cubes_;   // those that may meet the surface
  std::vector<std::uint64_t> points_;  // their corners
  std::vector<double> values_;         // squares of distances
  std::vector<Cube> mixed_;            // cubes with corners on both sides
  std::vector<std::uint8_t> cuts_;     // of each point, the directions of edges that are cut
  std::vector<std::uint32_t> firsts_;  // their first vertex
  TriangleMesh mesh_;
};

}  // namespace

double offsetMargin(double reach, double spacing) { return levelOf(reach, spacing) + 3 * spacing; }

double farthestOfOffset(double reach, double spacing) {
  return levelOf(reach, spacing) + (kHalfDiagonal + kMoved) * spacing;
}

OffsetSurface offsetSurface(const TriangleMesh& surface, const VisitLattice& visits, double reach,
                            const model::Progress& progress) {
  return {Offset(surface, visits, reach).make(progress),
          farthestOfOffset(reach, visits.lattice().spacing)};
}

}  // namespace t4d::measure
