#include "measure/offset_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measure/marching_tetrahedra.h"
#include "measure/triangle_tree.h"
#include "model/parallel.h"
#include "model/progress.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

constexpr double kHalfDiagonal = std::numbers::sqrt3 / 2;
/// The distance by which vertices are moved along the longest edge.
constexpr double kMoved = std::numbers::sqrt3 * kOffsetMargin;

double levelOf(double reach, double spacing) {
  return std::hypot(reach + kMoved * spacing, kHalfDiagonal * spacing);
}

/// The longest edge of pieces of triangles, in units: some voxels.
constexpr double kLongest = 16;

class Offset {
 public:
  Offset(const TriangleMesh& surface, const VisitLattice& visits, double reach)
      : visits_(visits),
        lattice_(visits.lattice()),
        // A power of two, which brings the spacing near 1: squares neither over- nor underflow.
        unit_(std::ldexp(1.0, -std::ilogb(lattice_.spacing))),
        level_(levelOf(reach, lattice_.spacing) * unit_),
        tree_(scaled(surface)) {}

  Result<TriangleMesh> make(const model::Progress& progress) {
    if (auto found = findCubes(model::partOf(progress, 0, 0.5)); !found) return found.error();
    if (auto found = findValues(model::partOf(progress, 0.5, 0.9)); !found) return found.error();
    return marchingTetrahedra(lattice_, cubes_, values_, level_ * level_, kOffsetMargin,
                              model::partOf(progress, 0.9, 1));
  }

 private:
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
    const Point3 from = lattice_.place(low) * unit_;
    const Point3 to = lattice_.place(high) * unit_;
    const double half = kSlack * (to - from).norm() / 2;
    const double distance = tree_.nearest((from + to) / 2, level_ + half).distance;
    return distance < level_ + half && distance > level_ - half;
  }

  /// Where corners on both sides differ, one is no farther than the level from the set's surface
  /// and the other farther: an edge is no longer than sqrt(3) spacings, and the level half of that
  /// at least, so the set's surface does not pass between points that are both farther away.
  Result<void> findCubes(const model::Progress& progress) {
    auto cubes = cubesThatMeet(
        lattice_, [&](const LatticeIndex& low, std::uint32_t size) { return mayMeet(low, size); },
        progress);
    if (!cubes) return cubes.error();
    cubes_ = std::move(*cubes);
    return {};
  }

  Result<void> findValues(const model::Progress& progress) {
    std::vector<std::uint64_t>& points = values_.points;
    std::vector<double>& values = values_.values;
    points = allCornersOf(cubes_);
    values.resize(points.size());
    const double most = level_ + 2 * std::numbers::sqrt3 * lattice_.spacing * unit_;
    return model::forEach(points.size(), progress, [&](std::size_t i) {
      const LatticeIndex point = indexOf(points[i]);
      if (visits_.isInside(point)) return;
      const double distance = tree_.nearest(lattice_.place(point) * unit_, most).distance;
      values[i] = distance * distance;
    });
  }

  const VisitLattice& visits_;
  const SpaceLattice& lattice_;
  double unit_;
  double level_;                      // in units
  TriangleTree tree_;                 // in units
  std::vector<std::uint64_t> cubes_;  // those that may meet the surface
  LatticeValues values_;              // at their corners: squares of distances
};

}  // namespace

double offsetMargin(double reach, double spacing) { return levelOf(reach, spacing) + 3 * spacing; }

double farthestOfOffset(double reach, double spacing) {
  return levelOf(reach, spacing) + (kHalfDiagonal + kMoved) * spacing;
}

Result<OffsetSurface> offsetSurface(const TriangleMesh& surface, const VisitLattice& visits,
                                    double reach, const model::Progress& progress) {
  auto mesh = Offset(surface, visits, reach).make(progress);
  if (!mesh) return mesh.error();
  return OffsetSurface{std::move(*mesh), farthestOfOffset(reach, visits.lattice().spacing)};
}

}  // namespace t4d::measure
