#include <algorithm>
#include <cstdlib>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "model/surface_edges.h"
#include "model/union_find.h"

namespace t4d::edit {
namespace {

using model::Triangle;
using model::TriangleMesh;

/// Drops parts between edges with an odd number of triangles. Returns how many triangles.
std::size_t dropStrayOnce(TriangleMesh& mesh) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  const auto countOf = [](const model::EdgeSides& edge) { return edge.end - edge.begin; };
  const auto isOdd = [&](const model::EdgeSides& edge) { return countOf(edge) % 2 != 0; };
  if (std::ranges::none_of(edges.edges,
                           [&](const auto& edge) { return isOdd(edge) && countOf(edge) > 2; })) {
    return 0;
  }
  model::UnionFind parts(mesh.triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    if (countOf(edge) != 2) continue;
    parts.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  struct Part {
    std::uint32_t root = 0;
    double area = 0;
    bool touches = false;   // an edge of three or more
    bool fits = true;       // all that it ends at has an odd number
    bool isOpen = false;    // it ends at an edge of its own
    std::int64_t gain = 0;  // how much better edges are balanced without it
    std::vector<std::uint32_t> ends;
  };
  std::vector<Part> all(mesh.triangles.size());
  double whole = 0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    Part& part = all[parts.root(i)];
    part.root = parts.root(i);
    part.area += areaOf(mesh, i);
    whole += areaOf(mesh, i);
  }
  std::vector<std::pair<std::uint32_t, int>> sides;  // their parts, and whether they go forward
  for (std::uint32_t e = 0; e < edges.edges.size(); ++e) {
    const model::EdgeSides& edge = edges.edges[e];
    if (countOf(edge) == 2) continue;
    sides.clear();
    int balance = 0;
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
      sides.emplace_back(parts.root(edges.sides[i] / 3), isForward(mesh, edges.sides[i]) ? 1 : -1);
      balance += sides.back().second;
    }
    std::ranges::sort(sides);
    for (std::size_t at = 0; at < sides.size();) {
      const std::size_t begin = at;
      Part& part = all[sides[at].first];
      int own = 0;
      for (; at < sides.size() && sides[at].first == sides[begin].first; ++at) {
        own += sides[at].second;
      }
      if ((at - begin) % 2 == 0) continue;
      part.touches |= countOf(edge) > 2;
      part.fits &= isOdd(edge);
      part.isOpen |= countOf(edge) == 1;
      part.gain += std::abs(balance) - std::abs(balance - own);
      part.ends.push_back(e);
    }
  }
  // A fin or a wall closes its own rim. What has much more area is a solid with a hole there. A
  // wall that is missed at its edges is a face in which another triangle is missing.
  std::erase_if(all, [&](const Part& part) {
    return !part.touches || !part.fits || part.area > whole / 2 ||
           (!part.isOpen && part.gain < 0) ||
           part.area > kOfRim * areaWithin(mesh, edges, part.ends);
  });
  std::ranges::sort(all, [](const Part& a, const Part& b) {
    return std::tie(a.area, a.root) < std::tie(b.area, b.root);
  });
  // Only the smallest of the parts that end at the same edge goes at a time.
  std::vector<bool> taken(edges.edges.size());
  std::vector<bool> stray(mesh.triangles.size());
  for (const Part& part : all) {
    if (std::ranges::any_of(part.ends, [&](std::uint32_t edge) { return taken[edge]; })) continue;
    for (const std::uint32_t edge : part.ends) taken[edge] = true;
    stray[part.root] = true;
  }
  std::uint32_t at = 0;
  return std::erase_if(mesh.triangles, [&](const Triangle&) { return stray[parts.root(at++)]; });
}

}  // namespace

double areaWithin(const TriangleMesh& mesh, const model::SurfaceEdges& edges,
                  const std::vector<std::uint32_t>& rim) {
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t e : rim) {
    corners.push_back(edges.edges[e].low);
    corners.push_back(edges.edges[e].high);
  }
  std::ranges::sort(corners);
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const auto numberOfCorner = [&](std::uint32_t vertex) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(corners, vertex) - corners.begin());
  };
  model::UnionFind loops(corners.size());
  for (const std::uint32_t e : rim) {
    loops.unite(numberOfCorner(edges.edges[e].low), numberOfCorner(edges.edges[e].high));
  }
  std::vector<model::Point3> middles(corners.size(), model::Point3::Zero());
  std::vector<int> counts(corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    middles[loops.root(i)] += mesh.vertices[corners[i]];
    ++counts[loops.root(i)];
  }
  double area = 0;
  for (const std::uint32_t e : rim) {
    const std::uint32_t loop = loops.root(numberOfCorner(edges.edges[e].low));
    const model::Point3 middle = middles[loop] / counts[loop];
    const model::Point3 low = mesh.vertices[edges.edges[e].low] - middle;
    area += low.cross(mesh.vertices[edges.edges[e].high] - middle).norm() / 2;
  }
  return area;
}

void dropStray(TriangleMesh& mesh, Changes& changes) {
  std::size_t dropped = 0;
  while (const std::size_t now = dropStrayOnce(mesh)) dropped += now;
  note(changes, SurfaceFault::Stray, dropped,
       fmt::format("dropped {} of parts that hang at an edge or divide the inside",
                   numberOf(dropped, "triangle", "triangles")));
}

}  // namespace t4d::edit
