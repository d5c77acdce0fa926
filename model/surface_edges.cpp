#include "model/surface_edges.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace t4d::model {
namespace {

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

SurfaceEdges edgesOf(std::span<const Triangle> triangles) {
  std::uint32_t last = 0;
  for (const Triangle& triangle : triangles) last = std::max(last, std::ranges::max(triangle));
  const auto forSides = [&](auto work) {
    std::uint32_t side = 0;
    for (const auto& [a, b, c] : triangles) {
      work(std::min(a, b), std::max(a, b), side++);
      work(std::min(b, c), std::max(b, c), side++);
      work(std::min(c, a), std::max(c, a), side++);
    }
  };
  // The sides of each vertex to a larger one, with that in the high bits, so that they are short
  // runs to sort. Those of v end at ends[v].
  std::vector<std::uint32_t> ends(std::size_t{last} + 2);
  forSides([&](std::uint32_t low, std::uint32_t, std::uint32_t) { ++ends[low + 1]; });
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<std::uint64_t> keyed(ends.back());
  forSides([&](std::uint32_t low, std::uint32_t high, std::uint32_t side) {
    keyed[ends[low]++] = std::uint64_t{high} << 32 | side;
  });
  SurfaceEdges result;
  result.sides.reserve(keyed.size());
  result.edges.reserve(keyed.size() / 2);
  std::uint32_t at = 0;
  for (std::uint32_t low = 0; low <= last; ++low) {
    const std::uint32_t begin = at;
    std::sort(keyed.begin() + begin, keyed.begin() + ends[low]);
    for (; at < ends[low]; ++at) {
      const auto high = static_cast<std::uint32_t>(keyed[at] >> 32);
      if (at == begin || high != result.edges.back().high) {
        result.edges.push_back({low, high, at, at});
      }
      result.edges.back().end = at + 1;
      result.sides.push_back(static_cast<std::uint32_t>(keyed[at]));
    }
  }
  return result;
}

std::vector<std::uint32_t> matesOf(const TriangleMesh& mesh, const SurfaceEdges& edges) {
  std::vector<std::uint32_t> mates(edges.sides.size(), kNoIndex);
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

}  // namespace t4d::model
