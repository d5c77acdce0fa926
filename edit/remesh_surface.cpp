#include "edit/remesh_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "measure/marching_tetrahedra.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "model/unit_scale.h"
#include "model/voxel_size.h"

namespace t4d::edit {
namespace {

using measure::LatticeIndex;
using model::Point3;
using model::TriangleMesh;

/// Cubes of the lattice on each side of the mesh: the surface does not leave the convex hull unless
/// triangles cover each other.
constexpr std::uint32_t kMargin = 1 << 16;
constexpr std::uint32_t kMostSteps = measure::SpaceLattice::kMostPoints - 2 * kMargin;

class Remesher {
 public:
  /// `mesh` is in the unit of `scale`, `step` is not.
  Remesher(const TriangleMesh& mesh, double step, const model::UnitScale& scale)
      : winding_(mesh), tree_(mesh), givenStep_(step) {
    lattice_.spacing = scale.toUnit(step);
    const model::Bounds3 bounds = boundsOf(mesh);
    // The origin is no round number, so that faces of a mesh seldom lie in a plane of the lattice.
    const Point3 origin = bounds.min - lattice_.spacing * Point3(0.7312, 0.6171, 0.5689);
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = (bounds.max[axis] - bounds.min[axis]) / lattice_.spacing;
      const auto last = static_cast<std::int32_t>(kMargin + steps) + 3;
      lattice_.at[axis].reserve(static_cast<std::size_t>(last) + kMargin);
      for (auto i = -static_cast<std::int32_t>(kMargin); i < last; ++i) {
        lattice_.at[axis].push_back(origin[axis] + lattice_.spacing * i);
      }
    }
  }

  Result<TriangleMesh> remesh(const model::Progress& progress) {
    const auto near = measure::cubesThatMeet(
        lattice_,
        [&](const LatticeIndex& low, std::uint32_t size) { return isNearTriangle(low, size); },
        model::partOf(progress, 0, 0.3));
    if (!near) return near.error();
    visit(*near);
    // Nearly all is done in the first round; others follow the surface across holes.
    for (bool first = true; !front_.empty(); first = false) {
      if (seen_.size() > static_cast<std::size_t>(kMostRemeshedCells)) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("the surface passes through more than {:.3g} voxels of size {}",
                                kMostRemeshedCells, givenStep_),
                    {}, Remedy::RemeshSize);
      }
      const std::vector<std::uint64_t> cubes = std::exchange(front_, {});
      const auto shown = first ? model::partOf(progress, 0.3, 0.9) : model::Progress();
      if (auto found = findValues(cubes, shown); !found) return found.error();
      for (const std::uint64_t cube : cubes) {
        if (!follow(cube)) {
          return fail(ErrorCode::Unsupported, "what the triangles enclose has no end");
        }
      }
    }
    if (mixed_.empty()) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("the triangles enclose nothing that voxels of size {} show", givenStep_), {},
          Remedy::RemeshSize);
    }
    measure::LatticeValues values{measure::allCornersOf(mixed_)};
    for (const std::uint64_t point : values.points) values.values.push_back(values_.at(point));
    // Away from both ends, so that no triangle is flat.
    constexpr double kLeast = 0.05;
    return measure::marchingTetrahedra(lattice_, mixed_, values, 0, kLeast);
  }

 private:
  bool isNearTriangle(const LatticeIndex& low, std::uint32_t size) const {
    const double half = 0.5 * size * lattice_.spacing;
    // A little more than half the diagonal, for rounding.
    const double reach = 1.001 * std::numbers::sqrt3 * half;
    const Point3 middle = lattice_.place(low) + Point3::Constant(half);
    return tree_.nearest(middle, reach).distance < reach;
  }

  void visit(std::span<const std::uint64_t> cubes) {
    for (const std::uint64_t cube : cubes) {
      if (seen_.insert(cube).second) front_.push_back(cube);
    }
  }

  /// Finds the values at the corners of cubes: the distance from the triangles, in voxels, negative
  /// inside; never 0.
  Result<void> findValues(std::span<const std::uint64_t> cubes, const model::Progress& progress) {
    std::vector<std::uint64_t> points = measure::allCornersOf(cubes);
    std::erase_if(points, [&](std::uint64_t point) { return values_.contains(point); });
    // Crossings are kept away from the ends of edges, so the digits of a float do.
    std::vector<float> values(points.size());
    auto done = model::forEach(points.size(), progress, [&](std::size_t i) {
      const Point3 point = lattice_.place(measure::indexOf(points[i]));
      const auto distance =
          static_cast<float>(std::max(tree_.nearest(point).distance / lattice_.spacing, 1e-6));
      values[i] = winding_.at(point) > 0.5 ? -distance : distance;
    });
    if (!done) return done;
    for (std::size_t i = 0; i < points.size(); ++i) values_.emplace(points[i], values[i]);
    return {};
  }

  /// Visits the neighbours of a cube into which the surface goes on. False at the end of the
  /// lattice.
  bool follow(std::uint64_t cube) {
    const LatticeIndex low = measure::indexOf(cube);
    for (int axis = 0; axis < 3; ++axis) {
      if (low[axis] < 2 || low[axis] + 3 > lattice_.at[axis].size()) return false;
    }
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      if (values_.at(measure::keyOf(measure::cornerOf(low, corner))) < 0) inside |= 1U << corner;
    }
    if (inside == 0 || inside == 0xff) return true;
    mixed_.push_back(cube);
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        unsigned side = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
          if (((corner >> axis & 1U) != 0) == upper) side |= 1U << corner;
        }
        if ((inside & side) == 0 || (inside & side) == side) continue;
        LatticeIndex next = low;
        next[axis] += upper ? 1 : -1;
        visit(std::array{measure::keyOf(next)});
      }
    }
    return true;
  }

  measure::WindingNumber winding_;
  measure::TriangleTree tree_;
  measure::SpaceLattice lattice_;
  double givenStep_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<std::uint64_t> front_;
  std::unordered_map<std::uint64_t, float> values_;
  std::vector<std::uint64_t> mixed_;  // cubes with corners on both sides
};

}  // namespace

Result<TriangleMesh> remeshSurface(const TriangleMesh& mesh, double voxelSize,
                                   const model::Progress& progress) {
  if (mesh.triangles.empty()) return invalid("the mesh has no triangles");
  if (auto sized = model::checkVoxelSize(voxelSize, Remedy::RemeshSize); !sized) {
    return sized.error();
  }
  const model::UnitScale scale = model::UnitScale::of({&mesh});
  const TriangleMesh inUnit = scale.toUnit(mesh);
  const model::Bounds3 bounds = boundsOf(inUnit);
  const double longest = (bounds.max - bounds.min).maxCoeff();
  const double size = scale.toUnit(voxelSize);
  const double cells = surfaceArea(inUnit) / size / size;
  if (!(size > 0) || !(longest / size < kMostSteps) || !(cells < kMostRemeshedCells)) {
    const double least = scale.fromUnit(
        std::max(std::sqrt(surfaceArea(inUnit) / kMostRemeshedCells), longest / kMostSteps));
    return fail(
        ErrorCode::Unsupported,
        fmt::format("voxels of size {} are too small: the surface would pass through {:.2g} "
                    "of them, expected at most {:.2g}; a size of {:.3g} is the least",
                    voxelSize, cells, kMostRemeshedCells, 1.5 * least),
        {}, Remedy::RemeshSize);
  }
  auto made = Remesher(inUnit, voxelSize, scale).remesh(progress);
  if (made) {
    for (Point3& vertex : made->vertices) vertex = scale.fromUnit(vertex);
  }
  return made;
}

}  // namespace t4d::edit
