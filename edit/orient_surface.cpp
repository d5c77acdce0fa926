#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "edit/surface_crossings.h"
#include "measure/winding_number.h"
#include "model/surface_edges.h"
#include "model/union_find.h"
#include "model/volume.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// The number of times that each edge is traversed forward, less backward.
std::vector<int> balanceOf(const TriangleMesh& mesh, const model::SurfaceEdges& edges) {
  std::vector<int> balance(edges.edges.size());
  for (std::size_t e = 0; e < balance.size(); ++e) {
    for (std::uint32_t i = edges.edges[e].begin; i < edges.edges[e].end; ++i) {
      balance[e] += isForward(mesh, edges.sides[i]) ? 1 : -1;
    }
  }
  return balance;
}

std::uint32_t sidesAt(const model::EdgeSides& edge) { return edge.end - edge.begin; }

/// What is out of balance at edges of several triangles; those of one are holes.
std::uint64_t imbalanceIn(const TriangleMesh& mesh) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  const std::vector<int> balance = balanceOf(mesh, edges);
  std::uint64_t sum = 0;
  for (std::size_t e = 0; e < balance.size(); ++e) {
    if (sidesAt(edges.edges[e]) > 1) sum += static_cast<std::uint64_t>(std::abs(balance[e]));
  }
  return sum;
}

/// Forgets the mates of triangles that are connected with none that disagree.
void keepWhatAgrees(const TriangleMesh& mesh, const model::SurfaceEdges& edges,
                    std::vector<std::uint32_t>& mates) {
  model::UnionFind parts(mesh.triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    for (std::uint32_t i = edge.begin + 1; i < edge.end; ++i) {
      parts.unite(edges.sides[edge.begin] / 3, edges.sides[i] / 3);
    }
  }
  const std::vector<int> balance = balanceOf(mesh, edges);
  std::vector<bool> disagrees(mesh.triangles.size());
  for (std::size_t e = 0; e < balance.size(); ++e) {
    if (sidesAt(edges.edges[e]) < 2 || balance[e] == 0) continue;
    disagrees[parts.root(edges.sides[edges.edges[e].begin] / 3)] = true;
  }
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    if (!disagrees[parts.root(side / 3)]) mates[side] = model::kNoIndex;
  }
}

/// Triangles connected across edges of two.
model::UnionFind patchesAcrossTwo(const TriangleMesh& mesh, const model::SurfaceEdges& edges) {
  model::UnionFind patches(mesh.triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    if (sidesAt(edge) != 2) continue;
    patches.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  return patches;
}

/// How often each patch that is open at an edge traverses it forward, less how often backward.
std::vector<std::pair<std::uint32_t, int>> openPatchesAt(const TriangleMesh& mesh,
                                                         const model::SurfaceEdges& edges,
                                                         const model::EdgeSides& edge,
                                                         model::UnionFind& patches) {
  std::vector<std::pair<std::uint32_t, int>> sides;
  for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
    const std::uint32_t side = edges.sides[i];
    sides.emplace_back(patches.root(side / 3), isForward(mesh, side) ? 1 : -1);
  }
  std::ranges::sort(sides);
  std::vector<std::pair<std::uint32_t, int>> open;
  for (std::size_t i = 0; i < sides.size();) {
    const std::uint32_t patch = sides[i].first;
    int forward = 0;
    for (; i < sides.size() && sides[i].first == patch; ++i) forward += sides[i].second;
    if (forward != 0) open.emplace_back(patch, forward);
  }
  return open;
}

/// Turns patches as a whole, small ones first, as long as that balances the edges between them
/// better.
void turnPatches(TriangleMesh& mesh) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  model::UnionFind patches = patchesAcrossTwo(mesh, edges);
  std::vector<int> balance = balanceOf(mesh, edges);
  struct Rim {
    std::vector<std::pair<std::uint32_t, int>> edges;  // and how often forward
    double area = 0;
    bool turned = false;
  };
  std::vector<Rim> rims(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    rims[patches.root(i)].area += areaOf(mesh, i);
  }
  std::vector<std::uint32_t> open;
  for (std::uint32_t e = 0; e < balance.size(); ++e) {
    if (sidesAt(edges.edges[e]) < 3) continue;
    for (const auto& [patch, forward] : openPatchesAt(mesh, edges, edges.edges[e], patches)) {
      if (rims[patch].edges.empty()) open.push_back(patch);
      rims[patch].edges.emplace_back(e, forward);
    }
  }
  std::ranges::stable_sort(open, {}, [&](std::uint32_t patch) { return rims[patch].area; });
  // Each turn leaves less out of balance, so this ends; the bound is for the time that it takes.
  constexpr int kMostRounds = 100;
  bool changed = true;
  for (int round = 0; changed && round < kMostRounds; ++round) {
    changed = false;
    for (const std::uint32_t patch : open) {
      Rim& rim = rims[patch];
      std::int64_t gain = 0;
      for (const auto& [edge, forward] : rim.edges) {
        gain += std::abs(balance[edge]) - std::abs(balance[edge] - 2 * forward);
      }
      if (gain <= 0) continue;
      for (auto& [edge, forward] : rim.edges) {
        balance[edge] -= 2 * forward;
        forward = -forward;
      }
      rim.turned = !rim.turned;
      changed = true;
    }
  }
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (rims[patches.root(i)].turned) reverse(mesh.triangles[i]);
  }
}

/// The winding number of all other components at this one, rounded: the lowest, in triangles all
/// over it, apart from a small part of its area.
int depthOf(const TriangleMesh& mesh, const Component& component,
            const measure::WindingNumber& winding) {
  TriangleMesh alone{mesh.vertices, {}, {}};
  for (const std::uint32_t i : component.triangles) alone.triangles.push_back(mesh.triangles[i]);
  const measure::WindingNumber own(alone);
  constexpr std::size_t kAsked = 64;
  const std::size_t step = (component.triangles.size() + kAsked - 1) / kAsked;
  std::vector<std::pair<int, double>> depths;  // and areas
  double whole = 0;
  for (std::size_t i = 0; i < component.triangles.size(); i += step) {
    const std::uint32_t triangle = component.triangles[i];
    const auto& [a, b, c] = mesh.triangles[triangle];
    const Point3 middle = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3;
    const double depth = winding.at(middle) - own.at(middle);
    // It is in between where other components have a triangle at this place, too.
    constexpr double kSure = 0.25;
    if (!(std::abs(depth - std::round(depth)) < kSure)) continue;
    depths.emplace_back(static_cast<int>(std::lround(depth)), areaOf(mesh, triangle));
    whole += depths.back().second;
  }
  std::ranges::sort(depths);
  constexpr double kIgnored = 1.0 / 16;  // a cavity may break through the surface that it is in
  double below = 0;
  for (const auto& [depth, area] : depths) {
    below += area;
    if (below >= kIgnored * whole) return depth;
  }
  return 0;
}

}  // namespace

std::optional<std::size_t> turnToAgree(TriangleMesh& mesh,
                                       const std::vector<std::uint32_t>& mates) {
  enum class State : char { Unseen, Kept, Turned };
  std::vector<State> state(mesh.triangles.size(), State::Unseen);
  std::vector<std::uint32_t> part;
  std::size_t turned = 0;
  for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (state[seed] != State::Unseen) continue;
    part = {seed};
    state[seed] = State::Kept;
    std::array<double, 2> area = {0, 0};
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::uint32_t triangle = part[next];
      area[state[triangle] == State::Turned ? 1 : 0] += areaOf(mesh, triangle);
      for (std::uint32_t side = 3 * triangle; side < 3 * triangle + 3; ++side) {
        const std::uint32_t mate = mates[side];
        if (mate == model::kNoIndex) continue;
        const bool agrees = fromOf(mesh, side) == toOf(mesh, mate);
        const State expected =
            (state[triangle] == State::Kept) == agrees ? State::Kept : State::Turned;
        if (state[mate / 3] == State::Unseen) {
          state[mate / 3] = expected;
          part.push_back(mate / 3);
        } else if (state[mate / 3] != expected) {
          return std::nullopt;
        }
      }
    }
    if (area[1] <= area[0]) continue;
    for (const std::uint32_t triangle : part) {
      state[triangle] = state[triangle] == State::Kept ? State::Turned : State::Kept;
    }
  }
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (state[i] != State::Turned) continue;
    reverse(mesh.triangles[i]);
    ++turned;
  }
  return turned;
}

Result<void> orient(TriangleMesh& mesh, Changes& changes) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  auto mates = matesOf(mesh, edges);
  keepWhatAgrees(mesh, edges, mates);
  if (std::ranges::all_of(mates, [](std::uint32_t mate) { return mate == model::kNoIndex; })) {
    return {};
  }
  TriangleMesh across{mesh.vertices, mesh.triangles, {}};
  const bool acrossAll = turnToAgree(across, mates).has_value();
  // Where more than two triangles meet, the pairs may be others.
  for (const model::EdgeSides& edge : edges.edges) {
    if (sidesAt(edge) == 2) continue;
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) mates[edges.sides[i]] = model::kNoIndex;
  }
  TriangleMesh turned{mesh.vertices, mesh.triangles, {}};
  if (!turnToAgree(turned, mates)) {
    return fail(ErrorCode::Unsupported, "the surface has only one side, so it bounds no solid", {},
                Remedy::Remesh);
  }
  turnPatches(turned);
  if (acrossAll && imbalanceIn(across) < imbalanceIn(turned)) turned = std::move(across);
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i] != turned.triangles[i]) ++count;
  }
  mesh.triangles = std::move(turned.triangles);
  note(changes, SurfaceFault::Turned, count,
       fmt::format("turned {} to agree with the neighbours",
                   numberOf(count, "triangle", "triangles")));
  return {};
}

std::vector<Component> componentsOf(const TriangleMesh& mesh) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  model::UnionFind patches = patchesAcrossTwo(mesh, edges);
  model::UnionFind sets = patches;
  for (const model::EdgeSides& edge : edges.edges) {
    if (sidesAt(edge) < 3) continue;
    const auto open = openPatchesAt(mesh, edges, edge, patches);
    for (const auto& [patch, forward] : open) sets.unite(open.front().first, patch);
  }
  std::vector<std::uint32_t> number(mesh.triangles.size(), 0);
  std::vector<Component> components;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (sets.root(i) == i) {
      number[i] = static_cast<std::uint32_t>(components.size());
      components.emplace_back();
    }
    components[number[sets.root(i)]].triangles.push_back(i);
  }
  std::vector<Triangle> triangles;
  for (Component& component : components) {
    triangles.clear();
    for (const std::uint32_t i : component.triangles) triangles.push_back(mesh.triangles[i]);
    component.volume = model::signedVolume(mesh.vertices, triangles);
  }
  return components;
}

bool faceOutward(TriangleMesh& mesh, Changes& changes) {
  std::size_t turned = 0;
  const auto turnAll = [&](Component& component) {
    for (const std::uint32_t i : component.triangles) reverse(mesh.triangles[i]);
    component.volume = -component.volume;
    ++turned;
  };
  auto components = componentsOf(mesh);
  if (signedVolume(mesh) < 0) std::ranges::for_each(components, turnAll);
  // The largest comes first, so that what a component is in has its final orientation.
  std::ranges::sort(components, std::greater(),
                    [](const Component& component) { return std::abs(component.volume); });
  if (components.size() > 1) {
    for (Component& component : components) {
      if (component.volume >= 0) continue;
      if (depthOf(mesh, component, measure::WindingNumber(mesh)) < 1) turnAll(component);
    }
  }
  note(changes, SurfaceFault::InsideOut, turned,
       fmt::format("turned {} outward", numberOf(turned, "component", "components")));
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  if (findsCrossings() &&
      std::ranges::any_of(edges.edges, [](const auto& edge) { return sidesAt(edge) > 2; })) {
    return true;
  }
  if (components.size() < 2) return false;
  const measure::WindingNumber winding(mesh);
  return std::ranges::any_of(components, [&](const Component& component) {
    return depthOf(mesh, component, winding) != (component.volume < 0 ? 1 : 0);
  });
}

}  // namespace t4d::edit
