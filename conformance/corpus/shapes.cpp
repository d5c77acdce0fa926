#include "conformance/corpus/shapes.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "model/facets.h"
#include "t4d/surface.h"

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

Slab manySimplices() {
  constexpr std::uint32_t kSimplices = 13108;
  const Slab one = simplex()[0];
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 5 * kSimplices;
  Slab slab = one;
  slab.connectivity = connectivity;
  slab.vertices.clear();
  for (std::uint32_t i = 0; i < kSimplices; ++i) {
    slab.vertices.insert(slab.vertices.end(), one.vertices.begin(), one.vertices.end());
    for (const model::Cell& cell : one.connectivity->cells) {
      connectivity->cells.push_back(
          {cell[0] + 5 * i, cell[1] + 5 * i, cell[2] + 5 * i, cell[3] + 5 * i});
    }
  }
  return slab;
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
      // Vertices 2k and 2k + 1 of the layer are the positive and negative ends of axis k.
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

std::vector<Slab> manyCrosses() {
  constexpr std::uint32_t kCount = 8200;
  std::vector<Slab> slabs = crossPolytope();
  for (Slab& slab : slabs) {
    const Slab one = slab;
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->vertexCount = 7 * kCount;
    connectivity->lowerCount = kCount * one.connectivity->lowerCount;
    connectivity->upperCount = kCount * one.connectivity->upperCount;
    // Each vertex of the half is kCount vertices here.
    for (std::uint32_t i = 0; i < kCount; ++i) {
      for (model::Cell cell : one.connectivity->cells) {
        for (std::uint32_t& vertex : cell) vertex = kCount * vertex + i;
        connectivity->cells.push_back(cell);
      }
    }
    slab.connectivity = connectivity;
    slab.vertices.clear();
    for (const model::Point4& vertex : one.vertices) {
      slab.vertices.insert(slab.vertices.end(), kCount, vertex);
    }
  }
  return slabs;
}

Solid cornerTetrahedron() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}; }

Solid cube(double side) {
  Solid solid;
  for (unsigned corner = 0; corner < 8; ++corner) {
    solid.vertices.emplace_back((corner & 1U) != 0 ? side : 0, (corner & 2U) != 0 ? side : 0,
                                (corner & 4U) != 0 ? side : 0);
  }
  // One cell for each order in which a path from corner 0 to 7 can follow the axes.
  solid.cells = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                 {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  return solid;
}

Solid cubes(const std::vector<std::array<int, 3>>& corners) {
  const Solid unit = cube();
  Solid solid;
  std::map<std::array<int, 3>, std::uint32_t> numbers;
  for (const auto& corner : corners) {
    std::vector<std::uint32_t> vertices;
    for (const Point3& vertex : unit.vertices) {
      const std::array<int, 3> place = {corner[0] + static_cast<int>(vertex[0]),
                                        corner[1] + static_cast<int>(vertex[1]),
                                        corner[2] + static_cast<int>(vertex[2])};
      const auto [found, isNew] =
          numbers.emplace(place, static_cast<std::uint32_t>(solid.vertices.size()));
      if (isNew) solid.vertices.emplace_back(place[0], place[1], place[2]);
      vertices.push_back(found->second);
    }
    for (const Cell& cell : unit.cells) {
      solid.cells.push_back(
          {vertices[cell[0]], vertices[cell[1]], vertices[cell[2]], vertices[cell[3]]});
    }
  }
  return solid;
}

namespace {

/// The triangles that belong to a single cell, facing outward.
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

/// The cells of a step on the surface only: lower vertices start at 0, upper ones at `up`.
std::vector<Cell> threeCellPrisms(const std::vector<Triangle>& triangles, std::uint32_t up) {
  std::vector<Cell> cells;
  for (const Triangle& triangle : triangles) {
    const auto [corners, even] = model::orientedFacet(triangle[0], triangle[1], triangle[2]);
    const auto [a, b, c] = corners;
    // Diagonals run from the lower-numbered vertex below to the higher-numbered one above, so that
    // neighbours agree.
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

/// Cuts each prism into fourteen cells around means at the centre of each quadrilateral and of the
/// prism, numbered from `firstMean`.
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

Slab capSlab(const Solid& solid, const Pose& pose, bool start, bool cone) {
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = count + (cone ? 1 : 0);
  (start ? connectivity->upperCount : connectivity->lowerCount) = count;
  const std::uint32_t first = start && cone ? 1 : 0;
  if (cone) {
    const std::uint32_t apex = start ? 0 : count;
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), first);
    connectivity->means.add(all);
    for (const auto& [a, b, c] : surfaceOf(solid)) {
      // The triangle faces outward, so (apex, a, b, c) has a positive volume.
      if (start) {
        connectivity->cells.push_back({apex, a + first, b + first, c + first});
      } else {
        connectivity->cells.push_back({a, apex, b, c});
      }
    }
  } else {
    addCap(connectivity->cells, solid, start, 0);
  }
  Slab slab;
  slab.timeBegin = slab.timeEnd = pose.time;
  slab.connectivity = connectivity;
  slab.vertices.resize(connectivity->vertexCount);
  setLayer(slab, pose, first);
  model::setMeans(*connectivity, slab.vertices);
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
  if (options.capSlabs) slabs.push_back(capSlab(solid, poses.front(), true, options.cones));
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
  if (options.capSlabs) slabs.push_back(capSlab(solid, poses.back(), false, options.cones));
  return slabs;
}

namespace {

/// A copy of the slab with `vertices` stored in the interior, and one mean, of the first and the
/// last of them, after the other means.
Slab withInterior(const Slab& slab, const std::vector<Point4>& vertices) {
  const Connectivity& old = *slab.connectivity;
  const auto added = static_cast<std::uint32_t>(vertices.size());
  const auto renumbered = [&](std::uint32_t vertex) {
    return vertex < old.lowerCount     ? vertex
           : vertex < old.firstUpper() ? vertex + added
                                       : vertex + added + 1;
  };
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->lowerCount = old.lowerCount;
  connectivity->upperCount = old.upperCount;
  connectivity->vertexCount = old.vertexCount + added + 1;
  for (Cell cell : old.cells) {
    for (std::uint32_t& vertex : cell) vertex = renumbered(vertex);
    connectivity->cells.push_back(cell);
  }
  for (std::uint32_t i = 0; i < old.means.size(); ++i) {
    std::vector<std::uint32_t> sources;
    for (std::uint32_t k = old.means.offsets[i]; k < old.means.offsets[i + 1]; ++k) {
      sources.push_back(renumbered(old.means.sources[k]));
    }
    connectivity->means.add(sources);
  }
  connectivity->means.add(std::vector{old.lowerCount, old.lowerCount + added - 1});
  Slab made = slab;
  const auto at = [&](std::uint32_t vertex) { return made.vertices.begin() + vertex; };
  made.vertices.insert(at(old.firstUpper()), Point4::Zero());
  made.vertices.insert(at(old.lowerCount), vertices.begin(), vertices.end());
  model::setMeans(*connectivity, made.vertices);
  made.connectivity = connectivity;
  return made;
}

}  // namespace

std::vector<Slab> manyPrisms() {
  Solid solid;
  for (std::uint32_t i = 0; i < 1170; ++i) {
    const Point3 corner(2 * (i % 13), 2 * (i / 13 % 9), 2 * (i / 117));
    // In this order the last cells of a step have the last vertex of a layer as a source only.
    for (const unsigned vertex : {0, 2, 1, 3}) {
      solid.vertices.push_back(corner + cornerTetrahedron().vertices[vertex]);
    }
    solid.cells.push_back({4 * i, 4 * i + 2, 4 * i + 1, 4 * i + 3});
  }
  std::vector<Slab> slabs = sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 1})},
                                  {.prism = Prism::Fourteen});
  // Four simplices have vertices of their own, the last one has a mean as its first corner.
  std::vector<Point4> interior = {{-96, 1, 2, 0}};
  for (int i = 0; i < 4; ++i) {
    const Slab one = simplex(1, {-40, 4.0 * i, 0, 0})[0];
    interior.insert(interior.end(), one.vertices.begin(), one.vertices.end());
  }
  const Slab last = simplex(1, {-32, 1, 2, 0})[0];
  interior.insert(interior.end(), last.vertices.begin() + 1, last.vertices.end());
  interior.emplace_back(32, 1, 2, 0);
  Slab step = withInterior(slabs[1], interior);
  auto connectivity = std::make_shared<Connectivity>(*step.connectivity);
  const std::uint32_t first = connectivity->lowerCount + 1;
  std::vector<Cell>& cells = connectivity->cells;
  std::vector<Cell> before;
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (Cell cell : last.connectivity->cells) {
      for (std::uint32_t& vertex : cell) vertex += first + 5 * i;
      before.push_back(cell);
    }
  }
  cells.insert(cells.begin(), before.begin(), before.end());
  for (Cell cell : last.connectivity->cells) {
    for (std::uint32_t& vertex : cell) {
      vertex = vertex == 0 ? connectivity->firstUpper() - 1 : first + 20 + vertex - 1;
    }
    cells.push_back(cell);
  }
  step.connectivity = connectivity;
  slabs[1] = step;
  return slabs;
}

namespace {

using Place = std::array<int, 3>;

constexpr std::array<int, 4> kAxes = {0, 1, 2, 3};

/// The cells of a cubic 3-face of a hypercube whose lowest corner is at `low`, at time `time`. The
/// face has the hypercube's corners with `side` (0 or 1) along `normal` (3 for t), and faces
/// outward. `number` maps a position and a time to a vertex.
template <class Number>
void addCubicFace(std::vector<Cell>& cells, const Place& low, int time, int normal, int side,
                  Number number) {
  std::array<int, 3> axes{};
  std::remove_copy(kAxes.begin(), kAxes.end(), axes.begin(), normal);
  // The sign of det[n, e_i, e_j, e_k], with the axes in order and n along `normal`.
  const bool positive = (normal % 2 == 0) == (side == 1);
  do {
    int inversions = 0;
    for (int i = 0; i < 3; ++i) {
      for (int k = i + 1; k < 3; ++k) inversions += axes[i] > axes[k] ? 1 : 0;
    }
    std::array<int, 4> corner = {low[0], low[1], low[2], time};
    corner[normal] += side;
    Cell cell{};
    for (int i = 0; i < 4; ++i) {
      if (i > 0) ++corner[axes[i - 1]];
      cell[i] = number(Place{corner[0], corner[1], corner[2]}, corner[3]);
    }
    if ((inversions % 2 == 0) != positive) std::swap(cell[0], cell[1]);
    cells.push_back(cell);
  } while (std::next_permutation(axes.begin(), axes.end()));
}

/// Lattice points, numbered in the order in which they are first requested.
struct Lattice {
  std::map<Place, std::uint32_t> numbers;
  std::vector<Place> places;

  void add(const Place& place) {
    if (numbers.emplace(place, static_cast<std::uint32_t>(places.size())).second) {
      places.push_back(place);
    }
  }
};

}  // namespace

std::vector<Slab> cubesInTime(const std::vector<std::vector<Place>>& frames) {
  const auto isIn = [&](std::size_t frame, const Place& cube) {
    return frame < frames.size() &&
           std::find(frames[frame].begin(), frames[frame].end(), cube) != frames[frame].end();
  };
  std::vector<Lattice> layers(frames.size() + 1);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (const Place& cube : frames[k]) {
      for (int corner = 0; corner < 8; ++corner) {
        const Place place = {cube[0] + (corner & 1), cube[1] + (corner >> 1 & 1),
                             cube[2] + (corner >> 2)};
        layers[k].add(place);
        layers[k + 1].add(place);
      }
    }
  }
  std::vector<Slab> slabs;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const int time = static_cast<int>(k);
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->lowerCount = static_cast<std::uint32_t>(layers[k].places.size());
    connectivity->upperCount = static_cast<std::uint32_t>(layers[k + 1].places.size());
    connectivity->vertexCount = connectivity->lowerCount + connectivity->upperCount;
    const auto number = [&](const Place& place, int at) {
      return at == time ? layers[k].numbers.at(place)
                        : connectivity->lowerCount + layers[k + 1].numbers.at(place);
    };
    for (const Place& cube : frames[k]) {
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {0, 1}) {
          Place neighbour = cube;
          neighbour[axis] += side == 1 ? 1 : -1;
          if (!isIn(k, neighbour)) {
            addCubicFace(connectivity->cells, cube, time, axis, side, number);
          }
        }
      }
      if (!isIn(k + 1, cube)) addCubicFace(connectivity->cells, cube, time, 3, 1, number);
      if (k == 0) addCubicFace(connectivity->cells, cube, time, 3, 0, number);
    }
    if (k + 1 < frames.size()) {
      for (const Place& cube : frames[k + 1]) {
        if (!isIn(k, cube)) addCubicFace(connectivity->cells, cube, time + 1, 3, 0, number);
      }
    }
    Slab slab;
    slab.connectivity = connectivity;
    slab.timeBegin = time;
    slab.timeEnd = time + 1;
    for (const auto& [layer, at] : {std::pair{&layers[k], time}, {&layers[k + 1], time + 1}}) {
      for (const Place& place : layer->places) {
        slab.vertices.emplace_back(place[0], place[1], place[2], at);
      }
    }
    slabs.push_back(std::move(slab));
  }
  return slabs;
}

std::vector<Slab> withPoses(std::vector<Slab> slabs,
                            const std::function<model::Affine3x4(std::size_t k)>& poseOf,
                            bool float32) {
  auto reference = std::make_shared<std::vector<Point3>>();
  for (const Point4& vertex : slabs[0].upperLayer()) reference->push_back(vertex.head<3>());
  for (std::size_t k = 0; k < slabs.size(); ++k) {
    const Connectivity& connectivity = *slabs[k].connectivity;
    if (k > 0) std::ranges::copy(slabs[k - 1].upperLayer(), slabs[k].vertices.begin());
    if (connectivity.upperCount > 0) {
      const model::LayerPose pose{reference, poseOf(k), float32};
      for (std::size_t i = 0; i < reference->size(); ++i) {
        slabs[k].vertices[connectivity.firstUpper() + i].head<3>() = pose.at(i);
      }
      slabs[k].upperPose = std::make_shared<const model::LayerPose>(pose);
    }
    model::setMeans(connectivity, slabs[k].vertices);
  }
  return slabs;
}

model::Affine3x4 movedBy(const Point3& offset) {
  return (model::Affine3x4() << Eigen::Matrix3d::Identity(), offset).finished();
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
