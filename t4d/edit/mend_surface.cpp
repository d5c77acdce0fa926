#include "t4d/edit/mend_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "t4d/edit/fill_hole.h"
#include "t4d/edit/outer_surface.h"
#include "t4d/edit/remesh_surface.h"
#include "t4d/edit/surface_crossings.h"
#include "t4d/edit/surface_edges.h"
#include "t4d/measure/surface_distance.h"
#include "t4d/measure/winding_number.h"
#include "t4d/model/surface_check.h"
#include "t4d/model/union_find.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// The search for crossings ends here; cutting more would take minutes.
constexpr std::size_t kMostCrossings = 200'000;
/// Rounding the places of cuts can make new crossings, of the size of the rounding.
constexpr int kMostCuts = 8;

using Changes = std::vector<SurfaceChange>;

void note(Changes& changes, SurfaceFault kind, std::uint64_t count, std::string text) {
  if (count > 0) changes.push_back({kind, count, std::move(text)});
}

std::string numberOf(std::uint64_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

bool hasTwice(const Triangle& triangle) {
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

Result<void> checkElements(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return invalid("the mesh has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      return invalid(fmt::format("vertex {} has a coordinate that is not finite", i));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t largest = *std::ranges::max_element(mesh.triangles[i]);
    if (largest >= mesh.vertices.size()) {
      return invalid(fmt::format("triangle {} has the vertex {}, but there are only {}", i, largest,
                                 mesh.vertices.size()));
    }
  }
  return {};
}

/// Merges vertices within `tolerance` of each other along each axis, through chains of such pairs,
/// into the first of them, and drops those without triangles. Returns how many were merged.
std::size_t weldVertices(TriangleMesh& mesh, double tolerance) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto& places = mesh.vertices;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (tolerance > 0 && places[a].x() != places[b].x()) return places[a].x() < places[b].x();
    return std::lexicographical_compare(places[a].begin(), places[a].end(), places[b].begin(),
                                        places[b].end());
  });
  model::UnionFind sets(count);
  std::size_t merged = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const Point3 apart = (places[order[j]] - places[order[i]]).cwiseAbs();
      if (apart[0] > tolerance) break;
      if (apart.maxCoeff() <= tolerance) {
        merged += sets.unite(order[i], order[j]) ? 1 : 0;
      } else if (tolerance == 0) {
        break;  // equal vertices are next to each other
      }
    }
  }
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) corner = sets.root(corner);
  }
  return merged;
}

void dropUnusedVertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> number(mesh.vertices.size(), kUnused);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) number[corner] = 0;
  }
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == kUnused) continue;
    number[i] = kept;
    mesh.vertices[kept++] = mesh.vertices[i];
  }
  mesh.vertices.resize(kept);
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
}

void weld(TriangleMesh& mesh, double tolerance, Changes& changes) {
  const std::size_t merged = weldVertices(mesh, tolerance);
  note(changes, SurfaceFault::Doubled, merged,
       tolerance > 0
           ? fmt::format("merged {} within {} of others", numberOf(merged, "vertex", "vertices"),
                         tolerance)
           : fmt::format("merged {} equal to others", numberOf(merged, "vertex", "vertices")));
}

/// Of triangles with the same corners, keeps the first.
void dropDuplicates(TriangleMesh& mesh, Changes& changes) {
  const std::size_t collapsed = std::erase_if(mesh.triangles, hasTwice);
  struct Keyed {
    Triangle corners;
    std::uint32_t triangle;
  };
  std::vector<Keyed> keyed;
  keyed.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle corners = mesh.triangles[i];
    std::ranges::sort(corners);
    keyed.push_back({corners, i});
  }
  std::ranges::sort(keyed, [](const Keyed& a, const Keyed& b) {
    return std::tie(a.corners, a.triangle) < std::tie(b.corners, b.triangle);
  });
  std::vector<bool> again(mesh.triangles.size());
  std::size_t duplicates = 0;
  for (std::size_t i = 1; i < keyed.size(); ++i) {
    if (keyed[i].corners != keyed[i - 1].corners) continue;
    again[keyed[i].triangle] = true;
    ++duplicates;
  }
  std::size_t at = 0;
  std::erase_if(mesh.triangles, [&](const Triangle&) { return again[at++]; });
  note(changes, SurfaceFault::Duplicate, collapsed,
       fmt::format("dropped {} with a corner twice", numberOf(collapsed, "triangle", "triangles")));
  note(changes, SurfaceFault::Duplicate, duplicates,
       fmt::format("dropped {} with the corners of another one",
                   numberOf(duplicates, "triangle", "triangles")));
}

double areaOf(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Point3& p = mesh.vertices[a];
  return (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm() / 2;
}

/// Drops parts between edges with an odd number of triangles. Returns how many triangles.
std::size_t dropStrayOnce(TriangleMesh& mesh) {
  const SurfaceEdges edges = edgesOf(mesh);
  const auto countOf = [](const EdgeSides& edge) { return edge.end - edge.begin; };
  const auto isOdd = [&](const EdgeSides& edge) { return countOf(edge) % 2 != 0; };
  if (std::ranges::none_of(edges.edges,
                           [&](const auto& edge) { return isOdd(edge) && countOf(edge) > 2; })) {
    return 0;
  }
  model::UnionFind parts(mesh.triangles.size());
  for (const EdgeSides& edge : edges.edges) {
    if (countOf(edge) != 2) continue;
    parts.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  struct Part {
    std::uint32_t root = 0;
    double area = 0;
    bool touches = false;  // an edge of three or more
    bool fits = true;      // all that it ends at has an odd number
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
  std::vector<std::uint32_t> roots;
  for (std::uint32_t e = 0; e < edges.edges.size(); ++e) {
    const EdgeSides& edge = edges.edges[e];
    if (countOf(edge) == 2) continue;
    roots.clear();
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
      roots.push_back(parts.root(edges.sides[i] / 3));
    }
    std::ranges::sort(roots);
    for (auto at = roots.begin(); at != roots.end();) {
      const auto end = std::upper_bound(at, roots.end(), *at);
      if ((end - at) % 2 != 0) {
        Part& part = all[*at];
        part.touches |= countOf(edge) > 2;
        part.fits &= isOdd(edge);
        part.ends.push_back(e);
      }
      at = end;
    }
  }
  std::erase_if(
      all, [&](const Part& part) { return !part.touches || !part.fits || part.area > whole / 2; });
  std::ranges::sort(all, [](const Part& a, const Part& b) {
    return std::tie(a.area, a.root) < std::tie(b.area, b.root);
  });
  // Of parts that end at the same edge, only the smallest at a time.
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

void dropStray(TriangleMesh& mesh, Changes& changes) {
  std::size_t dropped = 0;
  while (const std::size_t now = dropStrayOnce(mesh)) dropped += now;
  note(changes, SurfaceFault::Stray, dropped,
       fmt::format("dropped {} of parts that hang at an edge or divide the inside",
                   numberOf(dropped, "triangle", "triangles")));
}

void turn(Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

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
        if (mate == kNoSide) continue;
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
    turn(mesh.triangles[i]);
    ++turned;
  }
  return turned;
}

Result<void> orient(TriangleMesh& mesh, Changes& changes) {
  const SurfaceEdges edges = edgesOf(mesh);
  auto mates = matesOf(mesh, edges);
  auto turned = orientBy(mesh, mates);
  if (!turned) {
    // Where more than two triangles meet, the pairs may be others.
    for (const EdgeSides& edge : edges.edges) {
      if (edge.end - edge.begin == 2) continue;
      for (std::uint32_t i = edge.begin; i < edge.end; ++i) mates[edges.sides[i]] = kNoSide;
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

double widthOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  double squared = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    for (std::size_t k = i + 1; k < loop.size(); ++k) {
      squared = std::max(squared, (mesh.vertices[loop[i]] - mesh.vertices[loop[k]]).squaredNorm());
    }
  }
  return std::sqrt(squared);
}

Result<void> fillHoles(TriangleMesh& mesh, const MendSurfaceOptions& options, Changes& changes) {
  const auto loops = boundaryLoops(mesh, edgesOf(mesh));
  double widest = 0;
  std::size_t tooWide = 0;
  for (const auto& loop : loops) {
    const double width = widthOf(mesh, loop);
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
    const auto triangles = fillHole(mesh, loop);
    if (!triangles) return pass(triangles.error());
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

struct Component {
  std::vector<std::uint32_t> triangles;
  double volume = 0;
};

std::vector<Component> componentsOf(const TriangleMesh& mesh,
                                    const std::vector<std::uint32_t>& mates) {
  model::UnionFind sets(mesh.triangles.size());
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    if (mates[side] != kNoSide) sets.unite(side / 3, mates[side] / 3);
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
  for (Component& component : components) {
    const Point3 origin = mesh.vertices[mesh.triangles[component.triangles.front()][0]];
    for (const std::uint32_t i : component.triangles) {
      const auto& [a, b, c] = mesh.triangles[i];
      component.volume += (mesh.vertices[a] - origin)
                              .dot((mesh.vertices[b] - origin).cross(mesh.vertices[c] - origin)) /
                          6;
    }
  }
  return components;
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

/// Turns components that enclose a negative volume and are in no other. True if what remains is
/// nested otherwise than solids with cavities are.
bool faceOutward(TriangleMesh& mesh, Changes& changes) {
  std::size_t turned = 0;
  const auto turnAll = [&](Component& component) {
    for (const std::uint32_t i : component.triangles) turn(mesh.triangles[i]);
    component.volume = -component.volume;
    ++turned;
  };
  auto components = componentsOf(mesh, matesOf(mesh, edgesOf(mesh)));
  double whole = 0;
  for (const Component& component : components) whole += component.volume;
  if (whole < 0) std::ranges::for_each(components, turnAll);
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

Result<void> takeOuterSurface(TriangleMesh& mesh, bool nested, Changes& changes) {
  const model::Bounds3 bounds = boundsOf(mesh);
  const double size = std::max(bounds.max.cwiseAbs().maxCoeff(), bounds.min.cwiseAbs().maxCoeff());
  std::size_t pairs = 0;
  std::size_t flat = 0;
  std::uint64_t dropped = 0;
  for (int round = 0;; ++round) {
    const auto crossings = findCrossings(mesh, kMostCrossings);
    if (!crossings) return pass(crossings.error());
    if (round == 0) {
      pairs = crossings->pairs.size();
      flat = crossings->flat.size();
    }
    if (crossings->none() && !(nested && round == 0)) break;
    if (!crossings->complete || round == kMostCuts) {
      return fail(ErrorCode::Unsupported,
                  crossings->complete
                      ? "the outer surface still crosses itself when its vertices are rounded"
                      : fmt::format("more than {} pairs of triangles cross", kMostCrossings),
                  {}, Remedy::Remesh);
    }
    auto outer = outerSurface(mesh, *crossings);
    if (!outer) return pass(outer.error());
    if (outer->mesh.triangles.empty()) {
      return fail(ErrorCode::Unsupported, "the surface encloses nothing", {}, Remedy::Remesh);
    }
    if (round == 0) dropped = outer->dropped;
    mesh = std::move(outer->mesh);
    // First the rounding alone; then vertices that are as near as rounding may move them, more each
    // time.
    const double near = round == 0 ? 0 : std::ldexp(size, 2 * round - 52);
    weldVertices(mesh, near);
    std::erase_if(mesh.triangles, hasTwice);
    dropUnusedVertices(mesh);
  }
  if (pairs > 0) {
    note(changes, SurfaceFault::Crossing, pairs,
         fmt::format("took the outer surface where {} met: {} within it dropped",
                     numberOf(pairs, "pair of triangles", "pairs of triangles"),
                     numberOf(dropped, "piece", "pieces")));
  } else if (nested) {
    note(changes, SurfaceFault::Crossing, dropped,
         fmt::format("dropped {} of components inside others",
                     numberOf(dropped, "triangle", "triangles")));
  }
  note(changes, SurfaceFault::Duplicate, flat,
       fmt::format("dropped {} without area", numberOf(flat, "triangle", "triangles")));
  return {};
}

/// Puts a vertex in the middle of each edge with more than two triangles, so that what meets there
/// can be taken apart even if it is connected at both ends. Returns how many.
std::size_t divideNonManifoldEdges(TriangleMesh& mesh) {
  const SurfaceEdges edges = edgesOf(mesh);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crowded;
  for (const EdgeSides& edge : edges.edges) {
    if (edge.end - edge.begin > 2) crowded.emplace_back(edge.low, edge.high);
  }
  for (const auto& [low, high] : crowded) {
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(0.5 * mesh.vertices[low] + 0.5 * mesh.vertices[high]);
    const std::size_t count = mesh.triangles.size();
    for (std::size_t i = 0; i < count; ++i) {
      Triangle first = mesh.triangles[i];
      const auto l = std::ranges::find(first, low);
      const auto h = std::ranges::find(first, high);
      if (l == first.end() || h == first.end()) continue;
      Triangle second = first;
      second[l - first.begin()] = middle;
      *h = middle;
      mesh.triangles[i] = first;
      mesh.triangles.push_back(second);
    }
  }
  return crowded.size();
}

/// Gives each fan of triangles around a vertex a vertex of its own. Returns the vertices that have
/// several now, all of them.
std::vector<std::uint32_t> splitFans(TriangleMesh& mesh, std::size_t& split) {
  const auto mates = matesOf(mesh, edgesOf(mesh));
  model::UnionFind fans(mates.size());
  const auto cornerAt = [&](std::uint32_t triangle, std::uint32_t vertex) {
    const Triangle& corners = mesh.triangles[triangle];
    return static_cast<std::uint32_t>(3 * triangle +
                                      (std::ranges::find(corners, vertex) - corners.begin()));
  };
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    if (mates[side] == kNoSide) continue;
    for (const std::uint32_t vertex : {fromOf(mesh, side), toOf(mesh, side)}) {
      fans.unite(cornerAt(side / 3, vertex), cornerAt(mates[side] / 3, vertex));
    }
  }
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> firstFan(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> vertexOfFan(mates.size(), kNone);
  std::vector<bool> shared(mesh.vertices.size());
  std::vector<std::uint32_t> result;
  std::vector<Triangle> triangles = mesh.triangles;
  for (std::uint32_t corner = 0; corner < mates.size(); ++corner) {
    const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
    const std::uint32_t fan = fans.root(corner);
    if (vertexOfFan[fan] == kNone) {
      if (firstFan[vertex] == kNone) {
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
      }
    }
    triangles[corner / 3][corner % 3] = vertexOfFan[fan];
  }
  mesh.triangles = std::move(triangles);
  return result;
}

/// For each of these vertices, the direction out of its solid, with the length by which it can
/// safely move.
std::vector<Point3> outwardSteps(const TriangleMesh& mesh,
                                 const std::vector<std::uint32_t>& vertices) {
  constexpr double kOfDiagonal = 1e-5;
  constexpr double kOfEdge = 0.1;
  const model::Bounds3 bounds = boundsOf(mesh);
  const double most = kOfDiagonal * (bounds.max - bounds.min).norm();
  std::vector<std::uint32_t> index(mesh.vertices.size(), ~std::uint32_t{0});
  for (std::uint32_t i = 0; i < vertices.size(); ++i) index[vertices[i]] = i;
  std::vector<Point3> normals(vertices.size(), Point3::Zero());
  std::vector<double> shortest(vertices.size(), most / kOfEdge);
  for (const Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = index[triangle[k]];
      if (i == ~std::uint32_t{0}) continue;
      const Point3 to = mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]];
      const Point3 on = mesh.vertices[triangle[(k + 2) % 3]] - mesh.vertices[triangle[k]];
      const Point3 normal = to.cross(on);
      const double angle = std::atan2(normal.norm(), to.dot(on));
      normals[i] += angle * normal.stableNormalized();
      shortest[i] = std::min({shortest[i], to.norm(), on.norm()});
    }
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    normals[i] = kOfEdge * shortest[i] * normals[i].stableNormalized();
  }
  return normals;
}

/// Whether what a file would keep of the mesh, with equal vertices merged, bounds a solid.
Result<bool> isSound(const TriangleMesh& mesh) {
  TriangleMesh merged = mesh;
  weldVertices(merged, 0);
  if (!model::checkClosedSurface(merged)) return false;
  const auto crossings = findCrossings(merged, 1);
  if (!crossings) return pass(crossings.error());
  return crossings->none();
}

/// The number of triangles that meet others or are flat, with equal vertices merged.
Result<std::size_t> crossingsWhenMerged(TriangleMesh mesh) {
  weldVertices(mesh, 0);
  constexpr std::size_t kCounted = 1000;
  const auto crossings = findCrossings(mesh, kCounted);
  if (!crossings) return pass(crossings.error());
  return crossings->pairs.size() + crossings->flat.size();
}

Result<void> takeApart(TriangleMesh& mesh, Changes& changes) {
  TriangleMesh apart = mesh;
  const std::size_t edges = divideNonManifoldEdges(apart);
  std::size_t vertices = 0;
  const auto copies = splitFans(apart, vertices);
  if (copies.empty()) return {};
  const auto steps = outwardSteps(apart, copies);
  const auto moved = [&](const std::vector<double>& factors) {
    TriangleMesh result = apart;
    for (std::size_t i = 0; i < copies.size(); ++i) {
      result.vertices[copies[i]] += factors[i] * steps[i];
    }
    return result;
  };
  // Into the solid. Where surfaces are nested at a vertex, one of its copies has to go the other
  // way: found copy by copy, as the way with the fewest crossings.
  std::vector<double> factors(copies.size(), -1);
  constexpr std::size_t kMostTried = 64;
  constexpr int kRounds = 2;
  for (int round = 0; round <= (copies.size() <= kMostTried ? kRounds : 0); ++round) {
    for (std::size_t i = 0; round > 0 && i < copies.size(); ++i) {
      const auto found = crossingsWhenMerged(moved(factors));
      if (!found) return pass(found.error());
      std::size_t fewest = *found;
      double best = factors[i];
      for (const double factor : {-1.0, 1.0, -0.1, 0.1}) {
        factors[i] = factor;
        const auto tried = crossingsWhenMerged(moved(factors));
        if (!tried) return pass(tried.error());
        if (*tried >= fewest) continue;
        fewest = *tried;
        best = factor;
      }
      factors[i] = best;
    }
    TriangleMesh result = moved(factors);
    const auto sound = isSound(result);
    if (!sound) return pass(sound.error());
    if (!*sound) continue;
    mesh = std::move(result);
    note(changes, SurfaceFault::NonManifold, vertices,
         edges > 0 ? fmt::format("took apart what touched at {} and {}",
                                 numberOf(vertices - edges, "vertex", "vertices"),
                                 numberOf(edges, "edge", "edges"))
                   : fmt::format("took apart what touched at {}",
                                 numberOf(vertices, "vertex", "vertices")));
    return {};
  }
  return fail(ErrorCode::Unsupported,
              fmt::format("what touches at {} cannot be taken apart without crossings",
                          numberOf(vertices, "vertex", "vertices")),
              {}, Remedy::Remesh);
}

/// Steps 4 to 7 of mendSurface, on an oriented mesh.
Result<void> closeAndSeparate(TriangleMesh& mesh, const MendSurfaceOptions& options,
                              Changes& changes) {
  if (auto filled = fillHoles(mesh, options, changes); !filled) return filled;
  const bool nested = faceOutward(mesh, changes);
  if (auto outer = takeOuterSurface(mesh, nested, changes); !outer) return outer;
  if (auto apart = takeApart(mesh, changes); !apart) return apart;
  dropUnusedVertices(mesh);
  const auto sound = isSound(mesh);
  if (!sound) return pass(sound.error());
  if (*sound) return {};
  return fail(ErrorCode::Unsupported, "the mended surface would still have faults", {},
              Remedy::Remesh);
}

/// The last resort.
Result<void> remesh(TriangleMesh& mesh, double voxelSize, Changes& changes,
                    const model::Progress& progress) {
  // Of an open surface the sign is that of its cone from the middle.
  if (signedVolume(mesh) < 0) {
    for (Triangle& triangle : mesh.triangles) turn(triangle);
    note(changes, SurfaceFault::InsideOut, 1, "turned the surface outward");
  }
  auto made = remeshSurface(mesh, voxelSize, progress);
  if (!made) return pass(made.error());
  mesh = std::move(*made);
  note(changes, SurfaceFault::Remeshed, mesh.triangles.size(),
       fmt::format("made a new surface of {} from voxels of {}",
                   numberOf(mesh.triangles.size(), "triangle", "triangles"), voxelSize));
  return {};
}

Result<void> measureMove(const TriangleMesh& before, const TriangleMesh& after,
                         const MendSurfaceOptions& options, MendSurfaceReport& report) {
  constexpr double kTolerance = 1e-4;
  double tolerance = kTolerance;
  if (options.maxMove) {
    model::Bounds3 bounds = boundsOf(before);
    bounds.add(boundsOf(after));
    constexpr double kOfMove = 1.0 / 16;
    tolerance = std::min(tolerance, kOfMove * *options.maxMove / (bounds.max - bounds.min).norm());
  }
  const measure::SurfaceDistance moved = measure::surfaceDistance(before, after, tolerance);
  report.hausdorff = moved.hausdorff();
  if (!options.maxMove || moved.fromB + moved.tolerance <= *options.maxMove) return {};
  return invalid(
      fmt::format("the mended surface would be up to {:.6g} away from the given one, more "
                  "than {}",
                  moved.fromB, *options.maxMove),
      {}, Remedy::MaxMove);
}

}  // namespace

const char* nameOf(SurfaceFault kind) {
  switch (kind) {
    case SurfaceFault::Doubled:
      return "doubled";
    case SurfaceFault::Duplicate:
      return "duplicate";
    case SurfaceFault::Stray:
      return "stray";
    case SurfaceFault::Turned:
      return "turned";
    case SurfaceFault::Hole:
      return "hole";
    case SurfaceFault::InsideOut:
      return "inside-out";
    case SurfaceFault::Crossing:
      return "crossing";
    case SurfaceFault::NonManifold:
      return "non-manifold";
    case SurfaceFault::Remeshed:
      return "remeshed";
  }
  return "";
}

Result<MendSurfaceReport> mendSurface(TriangleMesh& mesh, const MendSurfaceOptions& options,
                                      const model::Progress& progress) {
  if (auto checked = checkElements(mesh); !checked) return pass(checked.error());
  MendSurfaceReport report;
  if (isClosed(mesh)) report.volumeBefore = signedVolume(mesh);
  TriangleMesh work;
  work.vertices = mesh.vertices;
  work.triangles = mesh.triangles;
  weld(work, options.weld, report.changes);
  dropDuplicates(work, report.changes);
  if (work.triangles.empty()) return invalid("no triangle has three different corners");
  dropStray(work, report.changes);
  dropUnusedVertices(work);
  auto done = orient(work, report.changes);
  TriangleMesh beforeHoles = work;
  const std::size_t changesBefore = report.changes.size();
  if (done) done = closeAndSeparate(work, options, report.changes);
  if (!done) {
    if (!options.remesh || done.error().remedy != Remedy::Remesh) return pass(done.error());
    work = std::move(beforeHoles);
    report.changes.resize(changesBefore);
    done = remesh(work, *options.remesh, report.changes, progress);
    if (!done) return pass(done.error());
    const auto sound = isSound(work);
    if (!sound) return pass(sound.error());
    if (!*sound) return fail(ErrorCode::Failed, "the new surface has faults");
  }
  if (!report.changes.empty()) {
    if (auto near = measureMove(mesh, work, options, report); !near) return pass(near.error());
  }
  report.volumeAfter = signedVolume(work);
  report.closed = true;
  report.manifold = true;
  report.components = componentsOf(work, matesOf(work, edgesOf(work))).size();
  mesh = std::move(work);
  return report;
}

}  // namespace t4d::edit
