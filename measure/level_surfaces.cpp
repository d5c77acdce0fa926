#include "measure/level_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::measure {

using model::kNoIndex;
using model::Point3;

LevelSurfaces levelSurfaces(std::span<const model::Cell> cells,
                            std::span<const std::uint8_t> above) {
  LevelSurfaces surfaces;
  surfaces.cut = slice::cutOf(cells, above);
  const slice::Cut& cut = surfaces.cut;
  const auto pointCount = static_cast<std::uint32_t>(cut.points.size());
  model::UnionFind sets(pointCount);
  for (const auto& [a, b, c] : cut.triangles) {
    sets.unite(a, b);
    sets.unite(b, c);
  }
  surfaces.ofPoint.resize(pointCount);
  for (std::uint32_t i = 0; i < pointCount; ++i) {
    const std::uint32_t root = sets.root(i);
    surfaces.ofPoint[i] = root == i ? surfaces.count++ : surfaces.ofPoint[root];
  }
  // A closed surface has three edges for every two triangles.
  surfaces.euler2.assign(surfaces.count, 0);
  for (const std::uint32_t surface : surfaces.ofPoint) surfaces.euler2[surface] += 2;
  for (const auto& triangle : cut.triangles) --surfaces.euler2[surfaces.ofPoint[triangle[0]]];
  return surfaces;
}

std::vector<std::uint8_t> verticesAfter(const model::Slab& slab, double time, bool orAt) {
  std::vector<std::uint8_t> above(slab.vertices.size());
  for (std::size_t i = 0; i < above.size(); ++i) {
    const double at = slab.vertices[i][3];
    above[i] = static_cast<std::uint8_t>(orAt ? at >= time : at > time);
  }
  return above;
}

std::vector<std::uint32_t> arcsOf(const LevelSurfaces& surfaces,
                                  const model::Connectivity& connectivity, const SlabReeb& reeb,
                                  std::uint32_t slot) {
  std::vector<std::uint32_t> arcs(surfaces.count, kNoIndex);
  const slice::Cut& cut = surfaces.cut;
  const auto surfaceOf = [&](std::size_t triangle) {
    return surfaces.ofPoint[cut.triangles[triangle][0]];
  };
  // An arc with a vertex in the slot has one in a cell of every slice there. All cells of others
  // last throughout the slot.
  for (std::size_t i = 0; i < cut.cells.size(); ++i) {
    std::uint32_t& arc = arcs[surfaceOf(i)];
    if (arc != kNoIndex) continue;
    for (const std::uint32_t vertex : connectivity.cells[cut.cells[i]]) {
      if (reeb.slotOfVertex[vertex] == slot) arc = reeb.arcOfVertex[vertex];
    }
  }
  for (const SlabReeb::Stretch& stretch : reeb.stretches) {
    if (stretch.firstSlot > slot || stretch.lastSlot < slot) continue;
    const auto at = std::ranges::lower_bound(cut.cells, stretch.cell);
    if (at == cut.cells.end() || *at != stretch.cell) continue;
    arcs[surfaceOf(static_cast<std::size_t>(at - cut.cells.begin()))] = stretch.arc;
  }
  return arcs;
}

std::vector<Point3> pointsAt(const slice::Cut& cut, std::span<const model::Point4> vertices,
                             double time) {
  std::vector<Point3> points;
  points.reserve(cut.points.size());
  for (const auto& [below, above] : cut.points) {
    const model::Point4& a = vertices[below];
    const model::Point4& b = vertices[above];
    if (a[3] >= time) {
      points.push_back(a.head<3>());
    } else if (b[3] <= time) {
      points.push_back(b.head<3>());
    } else {
      const double fraction = (time - a[3]) / (b[3] - a[3]);
      points.push_back(a.head<3>() + fraction * (b - a).head<3>());
    }
  }
  return points;
}

std::vector<SolidMeasures> measuresOf(const LevelSurfaces& surfaces, std::span<const Point3> points,
                                      double time) {
  std::vector<SolidMeasures> measures(surfaces.count);
  struct Sums {
    Point3 origin = Point3::Zero();  // near, so that little is lost far from that of space
    Point3 moment24 = Point3::Zero();
    double volume6 = 0;
    double area2 = 0;
    bool begun = false;
  };
  std::vector<Sums> sums(surfaces.count);
  for (const auto& [i, j, k] : surfaces.cut.triangles) {
    const std::uint32_t surface = surfaces.ofPoint[i];
    Sums& sum = sums[surface];
    if (!sum.begun) {
      sum.begun = true;
      sum.origin = points[i];
    }
    const Point3 a = points[i] - sum.origin;
    const Point3 b = points[j] - sum.origin;
    const Point3 c = points[k] - sum.origin;
    const Point3 normal = (b - a).cross(c - a);
    const double volume6 = a.dot(normal);
    sum.volume6 += volume6;
    sum.moment24 += volume6 * (a + b + c);
    sum.area2 += normal.norm();
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    measures[surfaces.ofPoint[i]].bounds.add(points[i]);
  }
  for (std::uint32_t s = 0; s < surfaces.count; ++s) {
    SolidMeasures& made = measures[s];
    made.time = time;
    made.volume = sums[s].volume6 / 6;
    made.area = sums[s].area2 / 2;
    made.genus = 1 - static_cast<double>(surfaces.euler2[s]) / 4;
    // A solid that has just appeared is flat, and its volume nothing but rounding.
    constexpr double kRounding = 1e-13;
    const double extent = (made.bounds.max - made.bounds.min).norm();
    const bool isFlat = std::abs(made.volume) <= kRounding * made.area * extent;
    made.centroid = isFlat ? Point3((made.bounds.min + made.bounds.max) / 2)
                           : Point3(sums[s].origin + sums[s].moment24 / 24 / made.volume);
  }
  return measures;
}

namespace {

// The direction is along no edge or side of lattices.
const Point3 kDirection = Point3(0.8363, 0.4621, 0.2953).normalized();

/// Triangles seen along that direction.
class AlongRays {
 public:
  /// Where a ray from a point meets a triangle, along it; nothing if it does not.
  std::optional<double> meets(const Point3& from, const std::array<Point3, 3>& corners) const {
    std::array<double, 3> x;
    std::array<double, 3> y;
    for (int c = 0; c < 3; ++c) {
      x[c] = (corners[c] - from).dot(right_);
      y[c] = (corners[c] - from).dot(up_);
    }
    const auto [lowX, highX] = std::ranges::minmax(x);
    const auto [lowY, highY] = std::ranges::minmax(y);
    if (lowX > 0 || highX < 0 || lowY > 0 || highY < 0) return {};
    // The areas of the triangles that the ray has with two corners each.
    std::array<double, 3> part;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3;
      part[(c + 2) % 3] = x[c] * y[d] - x[d] * y[c];
    }
    const auto [least, most] = std::ranges::minmax(part);
    const double sum = part[0] + part[1] + part[2];
    if ((least < 0 && most > 0) || sum == 0) return {};
    double along = 0;
    for (int c = 0; c < 3; ++c) along += part[c] / sum * (corners[c] - from).dot(kDirection);
    if (along < 0) return {};
    return along;
  }

 private:
  Point3 right_ = kDirection.cross(Point3::UnitZ()).normalized();
  Point3 up_ = kDirection.cross(right_);
};

}  // namespace

LocalSurface localSurface(const model::Slab& slab, std::span<const std::uint32_t> given,
                          double time, const Point3* place) {
  std::vector<model::Cell> cells;
  std::vector<model::Point4> vertices;
  std::vector<std::uint8_t> above;
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  double next = std::numeric_limits<double>::infinity();
  for (const std::uint32_t index : given) {
    model::Cell cell = slab.connectivity->cells[index];
    for (std::uint32_t& vertex : cell) {
      const model::Point4& at = slab.vertices[vertex];
      const auto [entry, isNew] =
          number.try_emplace(vertex, static_cast<std::uint32_t>(vertices.size()));
      vertex = entry->second;
      if (!isNew) continue;
      vertices.push_back(at);
      above.push_back(static_cast<std::uint8_t>(at[3] > time));
      if (at[3] > time) next = std::min(next, at[3]);
    }
    cells.push_back(cell);
  }
  LocalSurface found;
  LevelSurfaces surfaces = levelSurfaces(cells, above);
  for (const std::int64_t euler2 : surfaces.euler2) found.euler2 += euler2;
  const double between = time + (next - time) / 2;
  const auto points = pointsAt(surfaces.cut, vertices, between);
  for (const SolidMeasures& one : measuresOf(surfaces, points, between)) found.measures.add(one);
  if (place == nullptr) return found;
  const AlongRays rays;
  const auto then = pointsAt(surfaces.cut, vertices, time);
  for (const auto& [i, j, k] : surfaces.cut.triangles) {
    if (rays.meets(*place, {then[i], then[j], then[k]})) found.holdsPlace = !found.holdsPlace;
  }
  return found;
}

std::vector<std::uint32_t> nextSurfaces(const LevelSurfaces& surfaces,
                                        std::span<const Point3> points,
                                        std::span<const std::uint32_t> inner) {
  struct Ray {
    std::uint32_t from;
    Point3 origin = Point3::Zero();
    double start = -std::numeric_limits<double>::infinity();
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t found;
  };
  std::vector<std::uint32_t> rayOf(surfaces.count, kNoIndex);
  std::vector<Ray> rays;
  for (const std::uint32_t surface : inner) {
    rayOf[surface] = static_cast<std::uint32_t>(rays.size());
    rays.push_back({.from = surface, .found = surfaces.count});
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t number = rayOf[surfaces.ofPoint[i]];
    if (number == kNoIndex) continue;
    const double along = points[i].dot(kDirection);
    if (along > rays[number].start) {
      rays[number].start = along;
      rays[number].origin = points[i];
    }
  }
  const AlongRays seen;
  for (const auto& [i, j, k] : surfaces.cut.triangles) {
    const std::array<Point3, 3> corners = {points[i], points[j], points[k]};
    for (Ray& ray : rays) {
      if (surfaces.ofPoint[i] == ray.from) continue;
      const auto along = seen.meets(ray.origin, corners);
      if (!along || *along >= ray.nearest) continue;
      ray.nearest = *along;
      ray.found = surfaces.ofPoint[i];
    }
  }
  std::vector<std::uint32_t> found;
  for (const Ray& ray : rays) found.push_back(ray.found);
  return found;
}

}  // namespace t4d::measure
