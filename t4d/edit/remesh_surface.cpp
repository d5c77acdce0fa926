#include "t4d/edit/remesh_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "t4d/measure/triangle_tree.h"
#include "t4d/measure/winding_number.h"
#include "t4d/model/unit_scale.h"
#include "t4d/model/voxel_size.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

using Lattice = std::array<std::int32_t, 3>;

constexpr int kLatticeBits = 20;
/// Of the lattice, on each side of the mesh: its surface does not leave the convex hull unless
/// triangles cover each other.
constexpr std::int32_t kMargin = 1 << 16;
constexpr std::int32_t kMostSteps = (1 << kLatticeBits) - 2 * kMargin;

std::uint64_t keyOf(const Lattice& at) {
  std::uint64_t key = 0;
  for (const std::int32_t i : at) key = key << kLatticeBits | static_cast<std::uint64_t>(i);
  return key;
}

class Remesher {
 public:
  /// `mesh` is in the unit of `scale`, `step` is not.
  Remesher(const TriangleMesh& mesh, double step, const model::UnitScale& scale)
      : winding_(mesh),
        tree_(mesh),
        bounds_(boundsOf(mesh)),
        step_(scale.toUnit(step)),
        givenStep_(step) {
    // Not at round numbers, so that faces of a mesh seldom lie in a plane of the lattice.
    origin_ = bounds_.min - step_ * Point3(0.7312, 0.6171, 0.5689);
  }

  Result<TriangleMesh> remesh(const model::Progress& progress) {
    seed();
    const auto first = static_cast<double>(waiting_.size());
    std::size_t done = 0;
    while (!waiting_.empty()) {
      const Lattice cell = waiting_.back();
      waiting_.pop_back();
      if (seen_.size() > static_cast<std::size_t>(kMostRemeshedCells)) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("the surface passes through more than {:.3g} voxels of size {}",
                                kMostRemeshedCells, givenStep_),
                    {}, Remedy::RemeshSize);
      }
      if (!addCell(cell)) {
        return fail(ErrorCode::Unsupported, "what the triangles enclose has no end");
      }
      constexpr std::size_t kShownEvery = 4096;
      if (++done % kShownEvery == 0 && progress) {
        progress(std::min(1.0, static_cast<double>(done) / std::max(first, 1.0)));
      }
    }
    if (result_.triangles.empty()) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("the triangles enclose nothing that voxels of size {} show", givenStep_), {},
          Remedy::RemeshSize);
    }
    return std::move(result_);
  }

 private:
  Point3 place(const Lattice& at) const {
    return origin_ + step_ * Point3(at[0] - kMargin, at[1] - kMargin, at[2] - kMargin);
  }

  /// All cells within reach of a triangle, by halving blocks of cells.
  void seed() {
    const double longest = (bounds_.max - bounds_.min).maxCoeff() / step_ + 3;
    std::int32_t size = 1;
    while (size < longest) size *= 2;
    struct Block {
      Lattice at;
      std::int32_t size;
    };
    std::vector<Block> blocks = {{{kMargin - 1, kMargin - 1, kMargin - 1}, size}};
    while (!blocks.empty()) {
      const Block block = blocks.back();
      blocks.pop_back();
      const double half = 0.5 * block.size * step_;
      const Point3 middle = place(block.at) + Point3::Constant(half);
      // A little more than half the diagonal, for rounding.
      if (tree_.nearest(middle).distance > 1.001 * std::numbers::sqrt3 * half) continue;
      if (block.size == 1) {
        visit(block.at);
        continue;
      }
      const std::int32_t next = block.size / 2;
      for (unsigned corner = 0; corner < 8; ++corner) {
        blocks.push_back({cornerOf(block.at, corner, next), next});
      }
    }
  }

  static Lattice cornerOf(const Lattice& at, unsigned corner, std::int32_t step = 1) {
    return {at[0] + (corner & 1U ? step : 0), at[1] + (corner & 2U ? step : 0),
            at[2] + (corner & 4U ? step : 0)};
  }

  void visit(const Lattice& cell) {
    if (seen_.insert(keyOf(cell)).second) waiting_.push_back(cell);
  }

  /// The distance from the triangles, negative inside; never 0.
  double valueAt(const Lattice& at) {
    const auto [found, isNew] = values_.try_emplace(keyOf(at), 0.0F);
    if (isNew) {
      const Point3 point = place(at);
      // In voxels. Crossings are kept away from the ends of edges, so the digits of a float do.
      const auto distance =
          static_cast<float>(std::max(tree_.nearest(point).distance / step_, 1e-6));
      found->second = winding_.at(point) > 0.5 ? -distance : distance;
    }
    return found->second;
  }

  /// Adds the surface within a cell, and visits the neighbours into which it goes on. False at the
  /// end of the lattice.
  bool addCell(const Lattice& cell) {
    for (const std::int32_t i : cell) {
      if (i < 2 || i > (1 << kLatticeBits) - 4) return false;
    }
    std::array<double, 8> values;
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      values[corner] = valueAt(cornerOf(cell, corner));
      if (values[corner] < 0) inside |= 1U << corner;
    }
    if (inside == 0 || inside == 0xff) return true;
    // The six tetrahedra around the diagonal, each a path along three edges: neighbouring cubes cut
    // their common side in the same way.
    constexpr std::array<std::array<unsigned, 2>, 6> kPaths = {
        {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}}};
    for (const auto& [second, third] : kPaths) addTetrahedron(cell, {0, second, third, 7}, values);
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        unsigned side = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
          if (((corner >> axis & 1U) != 0) == upper) side |= 1U << corner;
        }
        if ((inside & side) == 0 || (inside & side) == side) continue;
        Lattice next = cell;
        next[axis] += upper ? 1 : -1;
        visit(next);
      }
    }
    return true;
  }

  void addTetrahedron(const Lattice& cell, const std::array<unsigned, 4>& corners,
                      const std::array<double, 8>& values) {
    std::array<unsigned, 4> in{};
    std::array<unsigned, 4> out{};
    std::size_t ins = 0;
    std::size_t outs = 0;
    for (const unsigned corner : corners) {
      if (values[corner] < 0) {
        in[ins++] = corner;
      } else {
        out[outs++] = corner;
      }
    }
    const auto cut = [&](unsigned from, unsigned to) { return cutOf(cell, from, to, values); };
    const Point3 outward = place(cornerOf(cell, out[0])) - place(cornerOf(cell, in[0]));
    if (ins == 1) {
      addTriangle({cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2])}, outward);
    } else if (outs == 1) {
      addTriangle({cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0])}, outward);
    } else if (ins == 2) {
      const std::uint32_t a = cut(in[0], out[0]);
      const std::uint32_t b = cut(in[0], out[1]);
      const std::uint32_t c = cut(in[1], out[1]);
      const std::uint32_t d = cut(in[1], out[0]);
      addTriangle({a, b, c}, outward);
      addTriangle({a, c, d}, outward);
    }
  }

  void addTriangle(model::Triangle corners, const Point3& outward) {
    const auto& [a, b, c] = corners;
    const auto& places = result_.vertices;
    const Point3 normal = (places[b] - places[a]).cross(places[c] - places[a]);
    if (normal.dot(outward) < 0) std::swap(corners[1], corners[2]);
    result_.triangles.push_back(corners);
  }

  /// The vertex between two corners of a cell, of which `from` is inside.
  std::uint32_t cutOf(const Lattice& cell, unsigned from, unsigned to,
                      const std::array<double, 8>& values) {
    const unsigned low = std::min(from, to);
    // From the lower end of an edge, 1 to 7 say where it goes.
    auto& cuts = cuts_[keyOf(cornerOf(cell, low))];
    std::uint32_t& vertex = cuts[(from ^ to) - 1];
    if (vertex == 0) {
      // Away from both ends, so that no triangle is flat.
      constexpr double kLeast = 0.05;
      const double t = std::clamp(values[from] / (values[from] - values[to]), kLeast, 1 - kLeast);
      const Point3 begin = place(cornerOf(cell, from));
      const Point3 end = place(cornerOf(cell, to));
      result_.vertices.emplace_back(begin + t * (end - begin));
      vertex = static_cast<std::uint32_t>(result_.vertices.size());
    }
    return vertex - 1;
  }

  measure::WindingNumber winding_;
  measure::TriangleTree tree_;
  model::Bounds3 bounds_;
  double step_;
  double givenStep_;
  Point3 origin_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<Lattice> waiting_;
  std::unordered_map<std::uint64_t, float> values_;
  std::unordered_map<std::uint64_t, std::array<std::uint32_t, 7>> cuts_;  // 0: none yet
  TriangleMesh result_;
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
