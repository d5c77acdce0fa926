#include "measure/marching_tetrahedra.h"

#include <algorithm>
#include <bit>

#include "model/parallel.h"
#include "model/progress.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

/// The tetrahedra about the diagonal of a cube, all with det[b - a, c - a, d - a] > 0. Those of
/// neighbours fit.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 2, 7, 3}, {0, 1, 7, 5}, {0, 4, 7, 6}}};

/// The even orders of four corners with each of them first.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kFirst = {
    {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}}};
/// Even orders with corners 0 and 1, 2 or 3 in front, and with the other two in front.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kPairs = {
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {2, 3, 0, 1}, {3, 1, 0, 2}, {1, 2, 0, 3}}};

class Tetrahedra {
 public:
  Tetrahedra(const SpaceLattice& lattice, const LatticeValues& values, double level, double margin)
      : lattice_(lattice),
        points_(values.points),
        values_(values.values),
        level_(level),
        margin_(margin) {}

  Result<TriangleMesh> march(std::span<const std::uint64_t> cubes,
                             const model::Progress& progress) {
    if (auto found = findMixed(cubes, progress); !found) return found.error();
    setVertices();
    setTriangles();
    return std::move(mesh_);
  }

 private:
  using Cube = std::array<std::uint32_t, 8>;  // its corners in points_

  bool isInside(std::uint32_t point) const { return values_[point] <= level_; }

  Result<void> findMixed(std::span<const std::uint64_t> cubes, const model::Progress& progress) {
    mixed_.resize(cubes.size());
    auto done = model::forEach(cubes.size(), progress, [&](std::size_t i) {
      for (unsigned corner = 0; corner < 8; ++corner) {
        const std::uint64_t key = keyOf(cornerOf(indexOf(cubes[i]), corner));
        mixed_[i][corner] =
            static_cast<std::uint32_t>(std::ranges::lower_bound(points_, key) - points_.begin());
      }
    });
    std::erase_if(mixed_, [&](const Cube& cube) {
      return std::ranges::all_of(cube, [&](auto point) { return isInside(point); }) ||
             std::ranges::none_of(cube, [&](auto point) { return isInside(point); });
    });
    return done;
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
        const double part = (level_ - values_[in]) / (values_[out] - values_[in]);
        const Point3 from = lattice_.place(indexOf(points_[in]));
        const Point3 to = lattice_.place(indexOf(points_[out]));
        mesh_.vertices[vertexOn(low, direction)] =
            from + std::clamp(part, margin_, 1 - margin_) * (to - from);
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

  const SpaceLattice& lattice_;
  std::span<const std::uint64_t> points_;
  std::span<const double> values_;
  double level_;
  double margin_;
  std::vector<Cube> mixed_;            // cubes with corners on both sides
  std::vector<std::uint8_t> cuts_;     // of each point, the directions of edges that are cut
  std::vector<std::uint32_t> firsts_;  // their first vertex
  TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> marchingTetrahedra(const SpaceLattice& lattice,
                                        std::span<const std::uint64_t> cubes,
                                        const LatticeValues& values, double level, double margin,
                                        const model::Progress& progress) {
  return Tetrahedra(lattice, values, level, margin).march(cubes, progress);
}

}  // namespace t4d::measure
