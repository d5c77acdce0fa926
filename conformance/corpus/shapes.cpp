#include "conformance/corpus/shapes.h"

#include <algorithm>
#include <map>
#include <utility>

#include "model/facets.h"

namespace t4d::conformance {

using model::Cell;
using model::Connectivity;
using model::Point3;
using model::Point4;
using model::Slab;
using model::Triangle;

std::vector<Slab> simplex(double size, const Point4& origin) {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  Slab slab;
  slab.connectivity = connectivity;
  slab.timeBegin = origin[3];
  slab.timeEnd = origin[3] + size;
  slab.vertices.push_back(origin);
  for (int axis = 0; axis < 4; ++axis) slab.vertices.push_back(origin + size * Point4::Unit(axis));
  return {slab};
}

std::vector<Slab> crossPolytope() {
  const auto half = [](double apexTime) {
    const bool first = apexTime < 0;
    const std::uint32_t apex = first ? 0 : 6;
    const std::uint32_t layer = first ? 1 : 0;
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->vertexCount = 7;
    (first ? connectivity->upperCount : connectivity->lowerCount) = 6;
    for (std::uint32_t signs = 0; signs < 8; ++signs) {
      // Vertices 2k and 2k + 1 of the layer are the positive and negative end of axis k.
      Cell cell = {layer + (signs & 1U), layer + 2 + (signs >> 1 & 1U), layer + 4 + (signs >> 2),
                   apex};
      const auto negative = static_cast<unsigned>(__builtin_popcount(signs)) + (first ? 1U : 0U);
      if (negative % 2 != 0) std::swap(cell[0], cell[1]);
      connectivity->cells.push_back(cell);
    }
    Slab slab;
    slab.connectivity = connectivity;
    slab.timeBegin = std::min(apexTime, 0.0);
    slab.timeEnd = std::max(apexTime, 0.0);
    slab.vertices.resize(7);
    slab.vertices[apex] = {0, 0, 0, apexTime};
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      slab.vertices[layer + 2 * axis] = Point4::Unit(axis);
      slab.vertices[layer + 2 * axis + 1] = -1 * Point4::Unit(axis) + Point4::Zero();
    }
    return slab;
  };
  return {half(-1), half(1)};
}

Solid cornerTetrahedron() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}; }

Solid cube(double side) {
  Solid solid;
  for (unsigned corner = 0; corner < 8; ++corner) {
    solid.vertices.emplace_back((corner & 1U) != 0 ? side : 0, (corner & 2U) != 0 ? side : 0,
                                (corner & 4U) != 0 ? side : 0);
  }
  // A cell for each order in which a path from corner 0 to 7 takes the axes.
  solid.cells = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                 {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  return solid;
}

Solid twoCubes() {
  Solid solid = cube();
  const Solid other = cube();
  for (const Point3& vertex : other.vertices) solid.vertices.push_back(vertex + Point3(3, 0, 0));
  for (const Cell& cell : other.cells) {
    solid.cells.push_back({cell[0] + 8, cell[1] + 8, cell[2] + 8, cell[3] + 8});
  }
  return solid;
}

namespace {

/// The triangles of cells that only one cell has, facing outward.
std::vector<Triangle> surfaceOf(const Solid& solid) {
  std::map<std::array<std::uint32_t, 3>, std::pair<int, bool>> facets;
  for (const Cell& cell : solid.cells) {
    for (int corner = 0; corner < 4; ++corner) {
      const model::OrientedFacet facet = model::facetOpposite(cell, corner);
      auto& [count, even] = facets[facet.vertices];
      ++count;
      even = facet.even;
    }
  }
  std::vector<Triangle> triangles;
  for (const auto& [vertices, found] : facets) {
    if (found.first != 1) continue;
    Triangle triangle = vertices;
    if (!found.second) std::swap(triangle[1], triangle[2]);
    triangles.push_back(triangle);
  }
  return triangles;
}

/// The cells of a step without the solid's own: lower vertices from 0, upper ones from `up`.
std::vector<Cell> threeCellPrisms(const std::vector<Triangle>& triangles, std::uint32_t up) {
  std::vector<Cell> cells;
  for (const Triangle& triangle : triangles) {
    const auto [corners, even] = model::orientedFacet(triangle[0], triangle[1], triangle[2]);
    const auto [a, b, c] = corners;
    // Diagonals go from the lower of two numbers below to the higher above, so that neighbours
    // agree.
    const std::array<Cell, 3> prism = {
        {{a, b, c, up + c}, {b, a, up + b, up + c}, {a, up + a, up + b, up + c}}};
    for (Cell cell : prism) {
      if (!even) std::swap(cell[0], cell[1]);
      cells.push_back(cell);
    }
  }
  return cells;
}

struct FourteenCells {
  std::vector<Cell> cells;
  model::Means means;
};

/// The same with a mean at the middle of each quadrilateral and each prism, numbered from
/// `firstMean`.
FourteenCells fourteenCellPrisms(const std::vector<Triangle>& triangles, std::uint32_t firstMean,
                                 std::uint32_t up) {
  FourteenCells step;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> quadrilaterals;
  const auto mean = [&](const std::vector<std::uint32_t>& sources) {
    step.means.add(sources);
    return firstMean + step.means.size() - 1;
  };
  for (const Triangle& triangle : triangles) {
    for (int i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      if (!quadrilaterals.contains({a, b})) {
        quadrilaterals[{a, b}] = mean({a, b, up + a, up + b});
      }
    }
  }
  for (const Triangle& triangle : triangles) {
    const auto [a, b, c] = triangle;
    const std::uint32_t middle = mean({a, b, c, up + a, up + b, up + c});
    step.cells.push_back({a, b, c, middle});
    step.cells.push_back({up + a, up + c, up + b, middle});
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = triangle[i];
      const std::uint32_t to = triangle[(i + 1) % 3];
      const auto [low, high] = std::minmax(from, to);
      const std::uint32_t around[] = {to, from, up + from, up + to};
      for (int k = 0; k < 4; ++k) {
        step.cells.push_back({around[k], around[(k + 1) % 4], quadrilaterals[{low, high}], middle});
      }
    }
  }
  return step;
}

void addCap(std::vector<Cell>& cells, const Solid& solid, bool start, std::uint32_t first) {
  for (Cell cell : solid.cells) {
    for (std::uint32_t& vertex : cell) vertex += first;
    if (!start) std::swap(cell[0], cell[1]);
    cells.push_back(cell);
  }
}

void setLayer(Slab& slab, const Pose& pose, std::uint32_t first) {
  for (std::size_t i = 0; i < pose.vertices.size(); ++i) {
    slab.vertices[first + i] << pose.vertices[i], pose.time;
  }
}

Slab capSlab(const Solid& solid, const Pose& pose, bool start) {
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = count;
  (start ? connectivity->upperCount : connectivity->lowerCount) = count;
  addCap(connectivity->cells, solid, start, 0);
  Slab slab;
  slab.timeBegin = slab.timeEnd = pose.time;
  slab.connectivity = connectivity;
  slab.vertices.resize(count);
  setLayer(slab, pose, 0);
  return slab;
}

}  // namespace

std::vector<Slab> sweep(const Solid& solid, const std::vector<Pose>& poses,
                        const SweepOptions& options) {
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  const std::vector<Triangle> surface = surfaceOf(solid);
  auto step = std::make_shared<Connectivity>();
  step->lowerCount = step->upperCount = count;
  step->vertexCount = 2 * count;
  if (options.prism == Prism::Fourteen) {
    const auto means = static_cast<std::uint32_t>(surface.size() * 5 / 2);  // E + F, 2 E = 3 F
    step->vertexCount += means;
    FourteenCells made = fourteenCellPrisms(surface, count, count + means);
    step->cells = std::move(made.cells);
    step->means = std::move(made.means);
  } else {
    step->cells = threeCellPrisms(surface, count);
  }
  std::vector<Slab> slabs;
  if (options.capSlabs) slabs.push_back(capSlab(solid, poses.front(), true));
  for (std::size_t k = 0; k + 1 < poses.size(); ++k) {
    Slab slab;
    slab.connectivity = step;
    const bool first = !options.capSlabs && k == 0;
    const bool last = !options.capSlabs && k + 2 == poses.size();
    if (first || last) {
      auto capped = std::make_shared<Connectivity>(*step);
      if (first) addCap(capped->cells, solid, true, 0);
      if (last) addCap(capped->cells, solid, false, capped->firstUpper());
      slab.connectivity = capped;
    }
    slab.timeBegin = poses[k].time;
    slab.timeEnd = poses[k + 1].time;
    slab.vertices.resize(step->vertexCount);
    setLayer(slab, poses[k], 0);
    setLayer(slab, poses[k + 1], step->firstUpper());
    model::setMeans(*step, slab.vertices);
    slabs.push_back(std::move(slab));
  }
  if (options.capSlabs) slabs.push_back(capSlab(solid, poses.back(), false));
  return slabs;
}

Pose pose(const Solid& solid, double time, const Point3& offset, double scale) {
  Pose pose{time, {}};
  for (const Point3& vertex : solid.vertices) pose.vertices.push_back(scale * vertex + offset);
  return pose;
}

Pose turned(const Solid& solid, double time, int k, const Point3& offset) {
  constexpr double kCosine = 0.6;
  constexpr double kSine = 0.8;
  Pose pose{time, {}};
  for (Point3 vertex : solid.vertices) {
    for (int i = 0; i < k; ++i) {
      vertex = {kCosine * vertex[0] - kSine * vertex[1], kSine * vertex[0] + kCosine * vertex[1],
                vertex[2]};
    }
    pose.vertices.push_back(vertex + offset);
  }
  return pose;
}

}  // namespace t4d::conformance
