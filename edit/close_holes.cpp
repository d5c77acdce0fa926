#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "edit/fill_hole.h"
#include "edit/mend_steps.h"
#include "model/surface_edges.h"

namespace t4d::edit {
namespace {

using model::TriangleMesh;

double widthOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  double squared = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    for (std::size_t k = i + 1; k < loop.size(); ++k) {
      squared = std::max(squared, (mesh.vertices[loop[i]] - mesh.vertices[loop[k]]).squaredNorm());
    }
  }
  return std::sqrt(squared);
}

/// For each side of a loop, the third vertex of a triangle that has it.
std::vector<std::uint32_t> apexesOf(const TriangleMesh& mesh, const model::SurfaceEdges& edges,
                                    const std::vector<std::uint32_t>& loop) {
  std::vector<std::uint32_t> apexes;
  apexes.reserve(loop.size());
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t from = loop[i];
    const auto [low, high] = std::minmax({from, loop[(i + 1) % loop.size()]});
    const auto edge = std::ranges::lower_bound(edges.edges, std::pair{low, high}, {},
                                               [](const model::EdgeSides& candidate) {
                                                 return std::pair{candidate.low, candidate.high};
                                               });
    const auto begin = edges.sides.begin() + edge->begin;
    const auto side = std::find_if(begin, edges.sides.begin() + edge->end,
                                   [&](std::uint32_t s) { return fromOf(mesh, s) == from; });
    apexes.push_back(apexOf(mesh, *side));
  }
  return apexes;
}

}  // namespace

Result<void> fillHoles(TriangleMesh& mesh, const MendSurfaceOptions& options,
                       const model::UnitScale& scale, Changes& changes) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  const auto loops = boundaryLoops(mesh, edges);
  double widest = 0;
  std::size_t tooWide = 0;
  for (const auto& loop : loops) {
    const double width = scale.fromUnit(widthOf(mesh, loop));
    widest = std::max(widest, width);
    if (options.maxHole && width > *options.maxHole) ++tooWide;
  }
  if (tooWide > 0) {
    return invalid(
        fmt::format("{} of {} wider than {}, the widest {:.6g}: more than may be filled", tooWide,
                    numberOf(loops.size(), "hole is", "holes are"), *options.maxHole, widest),
        {}, Remedy::MaxHole);
  }
  std::size_t filled = 0;
  std::size_t added = 0;
  for (const auto& loop : loops) {
    if (loop.size() < 3) continue;  // two triangles that go the same way along one edge
    const auto triangles = fillHole(mesh, loop, apexesOf(mesh, edges, loop));
    if (!triangles) return triangles.error();
    mesh.triangles.insert(mesh.triangles.end(), triangles->begin(), triangles->end());
    ++filled;
    added += triangles->size();
  }
  note(changes, SurfaceFault::Hole, filled,
       fmt::format("filled {} up to {:.6g} wide with {}", numberOf(filled, "hole", "holes"), widest,
                   numberOf(added, "triangle", "triangles")));
  if (!isClosed(mesh)) {
    return fail(ErrorCode::Unsupported, "the surface cannot be closed at its edges", {},
                Remedy::Remesh);
  }
  return {};
}

}  // namespace t4d::edit
