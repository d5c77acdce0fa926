#include "t4d/edit/surface_edges.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

bool isForward(const TriangleMesh& mesh, std::uint32_t side) {
  return fromOf(mesh, side) < toOf(mesh, side);
}

/// The sides at an edge, by the angle of their triangles around it: counter-clockwise seen from the
/// tip of the arrow from `low` to `high`.
std::vector<std::uint32_t> sidesAround(const TriangleMesh& mesh, const SurfaceEdges& edges,
                                       const EdgeSides& edge) {
  const Point3& origin = mesh.vertices[edge.low];
  const Point3 axis = (mesh.vertices[edge.high] - origin).stableNormalized();
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Point3 u = axis.cross(Point3::Unit(smallest)).stableNormalized();
  const Point3 v = axis.cross(u);
  std::vector<std::pair<double, std::uint32_t>> around;
  for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
    const Point3 to = mesh.vertices[apexOf(mesh, edges.sides[i])] - origin;
    around.emplace_back(std::atan2(to.dot(v), to.dot(u)), edges.sides[i]);
  }
  std::ranges::sort(around);
  std::vector<std::uint32_t> sides;
  for (const auto& [angle, side] : around) sides.push_back(side);
  return sides;
}

/// A triangle that traverses the edge forward has its outer side at larger angles. So solid ends
/// there and began at the triangle before, which traverses it backward.
bool pairAroundSolid(const TriangleMesh& mesh, const std::vector<std::uint32_t>& around,
                     std::vector<std::uint32_t>& mates) {
  const std::size_t count = around.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (isForward(mesh, around[i]) == isForward(mesh, around[(i + 1) % count])) return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!isForward(mesh, around[i])) continue;
    const std::uint32_t before = around[(i + count - 1) % count];
    mates[around[i]] = before;
    mates[before] = around[i];
  }
  return true;
}

}  // namespace

SurfaceEdges edgesOf(const TriangleMesh& mesh) {
  SurfaceEdges result;
  const auto count = static_cast<std::uint32_t>(3 * mesh.triangles.size());
  struct Keyed {
    std::uint64_t edge;
    std::uint32_t side;
  };
  std::vector<Keyed> keyed;
  keyed.reserve(count);
  for (std::uint32_t side = 0; side < count; ++side) {
    const std::uint64_t from = fromOf(mesh, side);
    const std::uint64_t to = toOf(mesh, side);
    keyed.push_back({std::min(from, to) << 32 | std::max(from, to), side});
  }
  std::ranges::sort(keyed, [](const Keyed& a, const Keyed& b) {
    return std::tie(a.edge, a.side) < std::tie(b.edge, b.side);
  });
  result.sides.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (i == 0 || keyed[i].edge != keyed[i - 1].edge) {
      result.edges.push_back({static_cast<std::uint32_t>(keyed[i].edge >> 32),
                              static_cast<std::uint32_t>(keyed[i].edge), i, i});
    }
    result.edges.back().end = i + 1;
    result.sides.push_back(keyed[i].side);
  }
  return result;
}

std::vector<std::uint32_t> matesOf(const TriangleMesh& mesh, const SurfaceEdges& edges) {
  std::vector<std::uint32_t> mates(edges.sides.size(), kNoSide);
  const auto pair = [&](std::uint32_t a, std::uint32_t b) {
    mates[a] = b;
    mates[b] = a;
  };
  for (const EdgeSides& edge : edges.edges) {
    const std::uint32_t count = edge.end - edge.begin;
    if (count % 2 != 0) continue;
    if (count == 2) {
      pair(edges.sides[edge.begin], edges.sides[edge.begin + 1]);
      continue;
    }
    const auto around = sidesAround(mesh, edges, edge);
    if (pairAroundSolid(mesh, around, mates)) continue;
    for (std::size_t i = 0; i < around.size(); i += 2) pair(around[i], around[i + 1]);
  }
  return mates;
}

std::vector<std::vector<std::uint32_t>> boundaryLoops(const TriangleMesh& mesh,
                                                      const SurfaceEdges& edges) {
  // What is left of the sides at each edge when those in opposite directions have cancelled; by the
  // vertex that they leave.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  for (const EdgeSides& edge : edges.edges) {
    int forward = 0;
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
      forward += isForward(mesh, edges.sides[i]) ? 1 : -1;
    }
    for (int i = 0; i < std::abs(forward); ++i) {
      open.emplace_back(forward > 0 ? edge.low : edge.high, forward > 0 ? edge.high : edge.low);
    }
  }
  std::ranges::sort(open);
  std::vector<bool> used(open.size());
  const auto nextFrom = [&](std::uint32_t vertex) {
    auto at = std::ranges::lower_bound(open, std::pair{vertex, std::uint32_t{0}}) - open.begin();
    while (at < std::ssize(open) && open[at].first == vertex && used[at]) ++at;
    return at;
  };
  // As many open sides enter a vertex as leave it, so a walk can only end where it began. A loop is
  // cut off as soon as the walk comes back to one of its vertices.
  std::vector<std::vector<std::uint32_t>> loops;
  std::vector<bool> onPath(mesh.vertices.size());
  for (std::size_t seed = 0; seed < open.size(); ++seed) {
    if (used[seed]) continue;
    std::vector<std::uint32_t> path = {open[seed].first};
    onPath[path.front()] = true;
    while (!path.empty()) {
      const auto at = nextFrom(path.back());
      if (at >= std::ssize(open) || open[at].first != path.back()) {
        onPath[path.back()] = false;
        path.pop_back();
        continue;
      }
      used[at] = true;
      const std::uint32_t to = open[at].second;
      if (!onPath[to]) {
        onPath[to] = true;
        path.push_back(to);
        continue;
      }
      std::vector<std::uint32_t> loop;
      const auto begin = std::ranges::find(path, to);
      loop.assign(begin, path.end());
      for (const std::uint32_t vertex : loop) onPath[vertex] = vertex == to;
      path.erase(begin + 1, path.end());
      loops.push_back(std::move(loop));
    }
  }
  return loops;
}

}  // namespace t4d::edit
