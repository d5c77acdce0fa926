#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "edit/surface_crossings.h"
#include "model/surface_check.h"
#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// Puts a vertex in the middle of each edge with more than two triangles, so that what meets there
/// can be taken apart even if it is connected at both ends. Adds the ends to `origins`.
void divideNonManifoldEdges(TriangleMesh& mesh, std::vector<VertexOrigin>& origins) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crowded;
  for (const model::EdgeSides& edge : edges.edges) {
    if (edge.end - edge.begin > 2) crowded.emplace_back(edge.low, edge.high);
  }
  // The triangles around the lower ends, in order; some that have been divided since are no longer.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> around;
  for (const auto& [low, high] : crowded) around[low];
  const auto list = [&](std::uint32_t triangle) {
    for (const std::uint32_t corner : mesh.triangles[triangle]) {
      if (const auto found = around.find(corner); found != around.end()) {
        found->second.push_back(triangle);
      }
    }
  };
  for (std::uint32_t i = 0; !crowded.empty() && i < mesh.triangles.size(); ++i) list(i);
  for (const auto& [low, high] : crowded) {
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middleOf(mesh.vertices, {low, high}));
    origins.push_back({low, high});
    for (const std::uint32_t i : std::vector(around[low])) {
      Triangle first = mesh.triangles[i];
      const auto l = std::ranges::find(first, low);
      const auto h = std::ranges::find(first, high);
      if (l == first.end() || h == first.end()) continue;
      Triangle second = first;
      second[l - first.begin()] = middle;
      *h = middle;
      mesh.triangles[i] = first;
      mesh.triangles.push_back(second);
      list(static_cast<std::uint32_t>(mesh.triangles.size() - 1));
    }
  }
}

/// Gives each fan of triangles around a vertex a vertex of its own, with the origins of that one.
/// Returns the vertices that have several now, all of them.
std::vector<std::uint32_t> splitFans(TriangleMesh& mesh, std::vector<VertexOrigin>& origins,
                                     std::size_t& split) {
  const auto mates = matesOf(mesh, model::edgesOf(mesh.triangles));
  model::UnionFind fans(mates.size());
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    if (mates[side] != model::kNoIndex) uniteCorners(fans, mesh, side, mates[side]);
  }
  std::vector<std::uint32_t> firstFan(mesh.vertices.size(), model::kNoIndex);
  std::vector<std::uint32_t> vertexOfFan(mates.size(), model::kNoIndex);
  std::vector<bool> shared(mesh.vertices.size());
  std::vector<std::uint32_t> result;
  std::vector<Triangle> triangles = mesh.triangles;
  for (std::uint32_t corner = 0; corner < mates.size(); ++corner) {
    const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
    const std::uint32_t fan = fans.root(corner);
    if (vertexOfFan[fan] == model::kNoIndex) {
      if (firstFan[vertex] == model::kNoIndex) {
        firstFan[vertex] = fan;
        vertexOfFan[fan] = vertex;
      } else {
        if (!shared[vertex]) {
          shared[vertex] = true;
          result.push_back(vertex);
          ++split;
        }
        vertexOfFan[fan] = static_cast<std::uint32_t>(mesh.vertices.size());
        result.push_back(vertexOfFan[fan]);
        mesh.vertices.emplace_back(Point3(mesh.vertices[vertex]));
        origins.push_back(VertexOrigin(origins[vertex]));
      }
    }
    triangles[corner / 3][corner % 3] = vertexOfFan[fan];
  }
  mesh.triangles = std::move(triangles);
  return result;
}

/// What may be done with one of several vertices at the same place.
struct Copy {
  std::uint32_t vertex = 0;
  double step = 0;                       ///< how far it may move
  Point3 outward = Point3::Zero();       ///< out of its solid, by the angles of its triangles
  Point3 toNeighbors = Point3::Zero();   ///< to the middle of the vertices around it
  std::vector<std::uint32_t> triangles;  ///< around it
};

std::vector<Copy> copiesOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  constexpr double kOfDiagonal = 1e-5;
  constexpr double kOfEdge = 0.1;
  const model::Bounds3 bounds = boundsOf(mesh);
  const double most = kOfDiagonal * (bounds.max - bounds.min).norm();
  std::vector<std::uint32_t> index(mesh.vertices.size(), model::kNoIndex);
  std::vector<Copy> copies(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    index[vertices[i]] = i;
    copies[i].vertex = vertices[i];
    copies[i].step = most;
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = index[triangle[k]];
      if (i == model::kNoIndex) continue;
      Copy& copy = copies[i];
      const Point3 to = mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]];
      const Point3 on = mesh.vertices[triangle[(k + 2) % 3]] - mesh.vertices[triangle[k]];
      const Point3 normal = to.cross(on);
      copy.outward += std::atan2(normal.norm(), to.dot(on)) * normal.stableNormalized();
      copy.toNeighbors += to.stableNormalized() + on.stableNormalized();
      copy.step = std::min({copy.step, kOfEdge * to.norm(), kOfEdge * on.norm()});
      copy.triangles.push_back(t);
    }
  }
  for (Copy& copy : copies) {
    copy.outward.stableNormalize();
    copy.toNeighbors.stableNormalize();
  }
  return copies;
}

/// The triangles near a copy, with vertices of their own. Equal ones are one, but for the copy.
struct Surroundings {
  TriangleMesh mesh;
  std::uint32_t vertex = 0;              ///< of the copy
  std::vector<std::uint32_t> triangles;  ///< around it
};

Surroundings surroundingsOf(const TriangleMesh& mesh, const Copy& copy) {
  model::Bounds3 bounds;
  for (const std::uint32_t triangle : copy.triangles) {
    for (const std::uint32_t corner : mesh.triangles[triangle]) bounds.add(mesh.vertices[corner]);
  }
  // The copy can go half as far, at most; the rest is for rounding.
  const Point3 reach = Point3::Constant(2 * copy.step);
  Surroundings result;
  std::map<std::array<double, 3>, std::uint32_t> numbers;
  const auto numberOf = [&](std::uint32_t vertex) {
    const Point3& place = mesh.vertices[vertex];
    const auto next = static_cast<std::uint32_t>(result.mesh.vertices.size());
    const auto [at, isNew] = numbers.try_emplace({place.x(), place.y(), place.z()}, next);
    if (isNew) result.mesh.vertices.emplace_back(place);
    return at->second;
  };
  result.mesh.vertices.emplace_back(mesh.vertices[copy.vertex]);
  for (const Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle;
    const Point3 low =
        mesh.vertices[a].cwiseMin(mesh.vertices[b]).cwiseMin(mesh.vertices[c]) - reach;
    const Point3 high =
        mesh.vertices[a].cwiseMax(mesh.vertices[b]).cwiseMax(mesh.vertices[c]) + reach;
    if ((low.array() > bounds.max.array()).any() || (high.array() < bounds.min.array()).any()) {
      continue;
    }
    Triangle corners;
    for (int i = 0; i < 3; ++i) {
      corners[i] = triangle[i] == copy.vertex ? result.vertex : numberOf(triangle[i]);
    }
    if (hasTwice(corners)) continue;
    if (std::ranges::find(corners, result.vertex) != corners.end()) {
      result.triangles.push_back(static_cast<std::uint32_t>(result.mesh.triangles.size()));
    }
    result.mesh.triangles.push_back(corners);
  }
  return result;
}

/// How many pairs of triangles meet that one of these is in, and how many of these are flat.
Result<std::size_t> faultsOf(std::span<const std::uint32_t> triangles, const TriangleMesh& mesh) {
  const auto crossings = findCrossingsOf(triangles, mesh);
  if (!crossings) return crossings.error();
  return crossings->pairs.size() + crossings->flat.size();
}

/// How much is wrong with the triangles around a copy at a place: whether it is that of another
/// vertex, the pairs of triangles that meet and the flat ones.
Result<std::size_t> faultsAt(const Point3& place, Surroundings& around) {
  TriangleMesh& mesh = around.mesh;
  mesh.vertices[around.vertex] = place;
  const auto equal = std::ranges::find(mesh.vertices.begin() + 1, mesh.vertices.end(), place);
  if (equal == mesh.vertices.end()) return faultsOf(around.triangles, mesh);
  TriangleMesh merged = mesh;
  const auto number = static_cast<std::uint32_t>(equal - mesh.vertices.begin());
  for (const std::uint32_t triangle : around.triangles) {
    std::ranges::replace(merged.triangles[triangle], around.vertex, number);
  }
  auto faults = faultsOf(around.triangles, merged);
  if (faults) ++*faults;
  return faults;
}

/// Moves a copy from its place `from` to where least is wrong around it.
Result<void> moveToBest(TriangleMesh& mesh, const Copy& copy, const Point3& from) {
  Surroundings around = surroundingsOf(mesh, copy);
  auto fewest = faultsAt(mesh.vertices[copy.vertex], around);
  if (!fewest) return fewest.error();
  const Point3 side = copy.outward.cross(copy.toNeighbors).stableNormalized();
  for (const double factor : {1.0, 0.1, 0.01}) {
    for (const Point3& way : {copy.outward, copy.toNeighbors, side,
                              Point3((copy.toNeighbors - copy.outward).stableNormalized())}) {
      for (const double sign : {-1.0, 1.0}) {
        if (*fewest == 0) return {};
        const Point3 place = from + sign * factor * copy.step * way;
        const auto found = faultsAt(place, around);
        if (!found) return found.error();
        if (*found >= *fewest) continue;
        fewest = *found;
        mesh.vertices[copy.vertex] = place;
      }
    }
  }
  return {};
}

/// The copies with a triangle that meets another or is flat, and those at one place.
Result<std::vector<std::uint32_t>> faultyAmong(const std::vector<Copy>& copies,
                                               const TriangleMesh& mesh) {
  constexpr std::size_t kMostPairs = 10'000;
  TriangleMesh merged = mesh;
  weldVertices(merged, 0);
  const auto crossings = findCrossings(merged, kMostPairs);
  if (!crossings) return crossings.error();
  std::vector<bool> bad(mesh.triangles.size());
  for (const std::uint32_t triangle : crossings->flat) bad[triangle] = true;
  for (const auto& [a, b] : crossings->pairs) bad[a] = bad[b] = true;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i] != merged.triangles[i]) bad[i] = true;
  }
  std::vector<std::uint32_t> faulty;
  for (std::uint32_t i = 0; i < copies.size(); ++i) {
    if (std::ranges::any_of(copies[i].triangles, [&](std::uint32_t t) { return bad[t]; })) {
      faulty.push_back(i);
    }
  }
  return faulty;
}

}  // namespace

Result<bool> isSound(const TriangleMesh& mesh) {
  TriangleMesh merged = mesh;
  weldVertices(merged, 0);
  if (!model::checkClosedSurface(merged)) return false;
  if (!findsCrossings()) return true;
  const auto crossings = findCrossings(merged, 1);
  if (!crossings) return crossings.error();
  return crossings->none();
}

SplitSurface splitWhereTouching(const TriangleMesh& mesh) {
  SplitSurface split{mesh};
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) split.origins.push_back({i, i});
  divideNonManifoldEdges(split.mesh, split.origins);
  split.edges = split.origins.size() - mesh.vertices.size();
  split.copies = splitFans(split.mesh, split.origins, split.vertices);
  return split;
}

void noteSplit(const SplitSurface& split, Changes& changes) {
  const std::size_t vertices = split.vertices;
  const std::size_t edges = split.edges;
  note(changes, SurfaceFault::NonManifold, vertices,
       edges > 0 ? fmt::format("took apart what touched at {} and {}",
                               numberOf(vertices - edges, "vertex", "vertices"),
                               numberOf(edges, "edge", "edges"))
                 : fmt::format("took apart what touched at {}",
                               numberOf(vertices, "vertex", "vertices")));
}

Result<void> takeApart(TriangleMesh& mesh, VertexLineage& lineage, Changes& changes) {
  const SplitSurface split = splitWhereTouching(mesh);
  if (split.copies.empty()) return {};
  TriangleMesh apart = split.mesh;
  const std::vector<Copy> copies = copiesOf(apart, split.copies);
  const std::vector<Point3> places = apart.vertices;
  // Copies move into the solid. Where surfaces are nested at a vertex, or a solid is too thin
  // there, some have to go another way: that with the fewest faults, one copy after the other.
  for (const Copy& copy : copies) apart.vertices[copy.vertex] -= copy.step * copy.outward;
  constexpr std::size_t kMostTried = 1000;
  constexpr int kRounds = 4;
  for (int round = 0; round <= kRounds; ++round) {
    const auto sound = isSound(apart);
    if (!sound) return sound.error();
    if (*sound) {
      mesh = std::move(apart);
      lineage.follow(split.origins);
      noteSplit(split, changes);
      return {};
    }
    const auto faulty = faultyAmong(copies, apart);
    if (!faulty) return faulty.error();
    if (faulty->size() > kMostTried) break;
    for (const std::uint32_t i : *faulty) {
      if (auto moved = moveToBest(apart, copies[i], places[copies[i].vertex]); !moved) {
        return moved.error();
      }
    }
  }
  return fail(ErrorCode::Unsupported,
              fmt::format("what touches at {} cannot be taken apart without crossings",
                          numberOf(split.vertices, "vertex", "vertices")),
              {}, Remedy::Remesh);
}

}  // namespace t4d::edit
