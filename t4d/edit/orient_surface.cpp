#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "t4d/edit/mend_steps.h"
#include "t4d/measure/winding_number.h"
#include "t4d/model/no_index.h"
#include "t4d/model/surface_edges.h"
#include "t4d/model/union_find.h"
#include "t4d/model/volume.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// Turns triangles until those that are `mates` agree. Returns how many, or nothing if there is no
/// way.
std::optional<std::size_t> orientBy(TriangleMesh& mesh, const std::vector<std::uint32_t>& mates) {
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

/// The winding number of all other components where this one is, rounded.
int depthOf(const TriangleMesh& mesh, const Component& component,
            const measure::WindingNumber& winding) {
  const std::uint32_t largest = *std::ranges::max_element(
      component.triangles, {}, [&](std::uint32_t i) { return areaOf(mesh, i); });
  const auto cornersOf = [&](std::uint32_t i) {
    const auto& [a, b, c] = mesh.triangles[i];
    return std::array<Point3, 3>{mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
  };
  const auto corners = cornersOf(largest);
  const Point3 middle = (corners[0] + corners[1] + corners[2]) / 3;
  double own = 0;
  for (const std::uint32_t i : component.triangles) {
    own += measure::WindingNumber::ofTriangle(cornersOf(i), middle);
  }
  return static_cast<int>(std::lround(winding.at(middle) - own));
}

}  // namespace

Result<void> orient(TriangleMesh& mesh, Changes& changes) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  auto mates = matesOf(mesh, edges);
  auto turned = orientBy(mesh, mates);
  if (!turned) {
    // Where more than two triangles meet, the pairs may be others.
    for (const model::EdgeSides& edge : edges.edges) {
      if (edge.end - edge.begin == 2) continue;
      for (std::uint32_t i = edge.begin; i < edge.end; ++i) mates[edges.sides[i]] = model::kNoIndex;
    }
    turned = orientBy(mesh, mates);
  }
  if (!turned) {
    return fail(ErrorCode::Unsupported, "the surface has only one side, so it bounds no solid", {},
                Remedy::Remesh);
  }
  note(changes, SurfaceFault::Turned, *turned,
       fmt::format("turned {} to agree with the neighbours",
                   numberOf(*turned, "triangle", "triangles")));
  return {};
}

std::vector<Component> componentsOf(const TriangleMesh& mesh,
                                    const std::vector<std::uint32_t>& mates) {
  model::UnionFind sets(mesh.triangles.size());
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    if (mates[side] != model::kNoIndex) sets.unite(side / 3, mates[side] / 3);
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
  auto components = componentsOf(mesh, matesOf(mesh, model::edgesOf(mesh.triangles)));
  if (signedVolume(mesh) < 0) std::ranges::for_each(components, turnAll);
  // From the largest on, so that what a component is in has its final orientation.
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
  if (components.size() < 2) return false;
  const measure::WindingNumber winding(mesh);
  return std::ranges::any_of(components, [&](const Component& component) {
    return depthOf(mesh, component, winding) != (component.volume < 0 ? 1 : 0);
  });
}

}  // namespace t4d::edit
