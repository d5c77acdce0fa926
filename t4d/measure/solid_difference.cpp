#include "t4d/measure/solid_difference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "t4d/model/no_index.h"
#include "t4d/model/surface_components.h"
#include "t4d/model/unit_scale.h"

namespace t4d::measure {
namespace {

using model::Bounds3;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// Each rotates the axes to directions that are unlikely to be parallel to a face of a man-made
/// object. No two are related by a symmetry of the cube, so their errors are independent.
const std::array<Eigen::Quaterniond, 4> kTurns = {Eigen::Quaterniond(0.837, 0.311, 0.229, 0.387),
                                                  Eigen::Quaterniond(0.611, -0.453, 0.539, 0.117),
                                                  Eigen::Quaterniond(0.283, 0.721, -0.167, 0.491),
                                                  Eigen::Quaterniond(0.467, 0.139, 0.823, -0.353)};

/// The lines are parallel to z, through the middles of columns of x and rows of y.
struct Lattice {
  double x0 = 0;
  double y0 = 0;
  double spacing = 1;
  std::int64_t columns = 0;
  std::int64_t rows = 0;

  double y(std::int64_t row) const { return y0 + (static_cast<double>(row) + 0.5) * spacing; }
  double x(std::int64_t column) const { return x0 + (static_cast<double>(column) + 0.5) * spacing; }
  /// The first row whose y is at least this, up to rounding; `rows` if there is none.
  std::int64_t rowFrom(double value) const {
    const double row = std::ceil((value - y0) / spacing - 0.5);
    return static_cast<std::int64_t>(std::clamp(row, 0.0, static_cast<double>(rows)));
  }
  /// The first column whose x is greater than this; the same for every triangle.
  std::int64_t columnAfter(double value) const {
    const double column = std::floor((value - x0) / spacing + 0.5);
    return static_cast<std::int64_t>(std::clamp(column, 0.0, static_cast<double>(columns)));
  }
};

Lattice latticeOver(const Bounds3& bounds, std::uint32_t resolution) {
  const Point3 size = bounds.max - bounds.min;
  Lattice lattice;
  lattice.spacing = std::max(size.x(), size.y()) / std::max(4U, resolution);
  const auto along = [&](double length) {
    return std::max<std::int64_t>(1, std::llround(std::ceil(length / lattice.spacing)));
  };
  lattice.x0 = bounds.min.x();
  lattice.y0 = bounds.min.y();
  lattice.columns = along(size.x());
  lattice.rows = along(size.y());
  // Not centred: with symmetric solids the lines would come in pairs with equal results.
  lattice.x0 = bounds.min.x() - 0.382 * lattice.spacing;
  lattice.y0 = bounds.min.y() - 0.236 * lattice.spacing;
  return lattice;
}

/// A mesh in the lattice's coordinates, with its triangles sorted into the rows they may meet.
class Rows {
 public:
  Rows(const TriangleMesh& mesh, const Lattice& lattice, const Eigen::Matrix3d& rotation,
       const Point3& middle)
      : mesh_(mesh), starts_(static_cast<std::size_t>(lattice.rows) + 1) {
    points_.reserve(mesh.vertices.size());
    for (const Point3& vertex : mesh.vertices) points_.push_back(rotation * (vertex - middle));
    const auto eachRow = [&](const Triangle& triangle, auto visit) {
      const auto [low, high] = std::minmax(
          {points_[triangle[0]].y(), points_[triangle[1]].y(), points_[triangle[2]].y()});
      const std::int64_t end = std::min(lattice.rows, lattice.rowFrom(high) + 1);
      for (std::int64_t row = std::max<std::int64_t>(0, lattice.rowFrom(low) - 1); row < end;
           ++row) {
        visit(static_cast<std::size_t>(row));
      }
    };
    for (const Triangle& triangle : mesh.triangles) {
      eachRow(triangle, [&](std::size_t row) { ++starts_[row + 1]; });
    }
    for (std::size_t row = 1; row < starts_.size(); ++row) starts_[row] += starts_[row - 1];
    triangles_.resize(starts_.back());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      eachRow(mesh.triangles[i], [&](std::size_t row) { triangles_[next[row]++] = i; });
    }
  }

  /// Calls `hit(column, z, turn)` where a line of the row goes through a triangle: behind it the
  /// winding number is greater than before it by `turn`, 1 or -1.
  ///
  /// Whether a row's y is above a vertex decides which edges the row crosses. An edge is crossed at
  /// the same point for both of its triangles, since that is computed from its lower end. A
  /// triangle is hit in the columns between its two crossed edges. So whatever the rounding,
  /// all triangles agree on the edges to the left of a column, and the turns of a closed mesh add
  /// up to 0.
  template <class Hit>
  void forEachHit(std::size_t row, const Lattice& lattice, Hit hit) const {
    struct Crossing {
      double x;
      double z;
      bool up;
    };
    const double y = lattice.y(static_cast<std::int64_t>(row));
    for (std::size_t at = starts_[row]; at < starts_[row + 1]; ++at) {
      const Triangle& triangle = mesh_.triangles[triangles_[at]];
      std::array<Crossing, 2> crossings{};
      std::size_t count = 0;
      for (int i = 0; i < 3; ++i) {
        const Point3* low = &points_[triangle[i]];
        const Point3* high = &points_[triangle[(i + 1) % 3]];
        const bool up = low->y() <= y;
        if (up == (high->y() <= y)) continue;
        if (!up) std::swap(low, high);
        const double s = (y - low->y()) / (high->y() - low->y());
        crossings[count++] = {low->x() + s * (high->x() - low->x()),
                              low->z() + s * (high->z() - low->z()), up};
      }
      if (count == 0) continue;
      if (crossings[1].x < crossings[0].x) std::swap(crossings[0], crossings[1]);
      const auto& [left, right] = crossings;
      const std::int64_t end = lattice.columnAfter(right.x);
      // If it is walked upward on its right, a triangle is counter-clockwise seen from +z: it faces
      // that way, and the line, which goes towards +z, leaves the solid.
      const int turn = right.up ? -1 : 1;
      for (std::int64_t column = lattice.columnAfter(left.x); column < end; ++column) {
        const double s = (lattice.x(column) - left.x) / (right.x - left.x);
        hit(column, left.z + s * (right.z - left.z), turn);
      }
    }
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<Point3> points_;
  std::vector<std::size_t> starts_;       // start of each row in triangles_
  std::vector<std::uint32_t> triangles_;  // by row
};

struct Hit {
  std::int64_t column;
  double z;
  int turnOfA;  // change of the winding number
  int turnOfB;
};

/// What is integrated, of the winding numbers of a and b; 0 where both are 0.
struct Integrand {
  std::int64_t (*of)(std::int64_t a, std::int64_t b);
  bool inBoth;  ///< it is 0 where either is 0
};

constexpr Integrand kDifference = {[](std::int64_t a, std::int64_t b) { return std::abs(a - b); },
                                   /*inBoth=*/false};
constexpr Integrand kOverlap = {
    [](std::int64_t a, std::int64_t b) { return std::max<std::int64_t>(0, std::min(a, b)); },
    /*inBoth=*/true};

/// The part that two bounds have in common, empty if they are apart.
Bounds3 common(Bounds3 a, const Bounds3& b) {
  a.min = a.min.cwiseMax(b.min);
  a.max = a.max.cwiseMin(b.max);
  return a;
}

/// Of all that the integrand is not 0 for, after the rotation.
Bounds3 rotatedBounds(const TriangleMesh& a, const TriangleMesh& b, const Integrand& integrand,
                      const Eigen::Matrix3d& rotation, const Point3& middle) {
  std::array<Bounds3, 2> bounds;
  for (const Point3& vertex : a.vertices) bounds[0].add(rotation * (vertex - middle));
  for (const Point3& vertex : b.vertices) bounds[1].add(rotation * (vertex - middle));
  if (!integrand.inBoth) {
    bounds[0].add(bounds[1]);
    return bounds[0];
  }
  const Bounds3 box = common(boundsOf(a), boundsOf(b));
  Bounds3 corners;
  for (unsigned k = 0; k < 8 && !box.empty(); ++k) {
    const Point3 corner((k & 1U) != 0 ? box.max.x() : box.min.x(),
                        (k & 2U) != 0 ? box.max.y() : box.min.y(),
                        (k & 4U) != 0 ? box.max.z() : box.min.z());
    corners.add(rotation * (corner - middle));
  }
  return common(common(bounds[0], bounds[1]), corners);
}

/// The integral along lines that are parallel to z after the rotation.
double integrate(const TriangleMesh& a, const TriangleMesh& b, const Integrand& integrand,
                 const Eigen::Matrix3d& rotation, const Point3& middle, std::uint32_t resolution) {
  const Bounds3 bounds = rotatedBounds(a, b, integrand, rotation, middle);
  if (bounds.empty() || !((bounds.max - bounds.min).head<2>().maxCoeff() > 0)) return 0;
  const Lattice lattice = latticeOver(bounds, resolution);
  const Rows rowsOfA(a, lattice, rotation, middle);
  const Rows rowsOfB(b, lattice, rotation, middle);
  double sum = 0;
  std::vector<Hit> hits;
  for (std::int64_t row = 0; row < lattice.rows; ++row) {
    hits.clear();
    const auto index = static_cast<std::size_t>(row);
    rowsOfA.forEachHit(index, lattice, [&](std::int64_t column, double z, int turn) {
      hits.push_back({column, z, turn, 0});
    });
    rowsOfB.forEachHit(index, lattice, [&](std::int64_t column, double z, int turn) {
      hits.push_back({column, z, 0, turn});
    });
    std::sort(hits.begin(), hits.end(), [](const Hit& p, const Hit& q) {
      return p.column != q.column ? p.column < q.column : p.z < q.z;
    });
    std::int64_t windingOfA = 0;  // 0 again after the last hit of a column
    std::int64_t windingOfB = 0;
    for (std::size_t i = 0; i + 1 < hits.size(); ++i) {
      windingOfA += hits[i].turnOfA;
      windingOfB += hits[i].turnOfB;
      const std::int64_t value = integrand.of(windingOfA, windingOfB);
      if (value != 0) sum += static_cast<double>(value) * (hits[i + 1].z - hits[i].z);
    }
  }
  return sum * lattice.spacing * lattice.spacing;
}

/// Parts of both surfaces whose bounds overlap, and perhaps those of others in between.
struct Group {
  Bounds3 bounds;
  TriangleMesh a;
  TriangleMesh b;
};

bool boundsOverlap(const Bounds3& a, const Bounds3& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

/// The connected components of a closed surface: the component of each vertex, and their bounds.
/// Vertices of no triangle have none.
std::pair<std::vector<std::uint32_t>, std::vector<Bounds3>> partsOf(const TriangleMesh& mesh) {
  model::UnionFind sets = model::componentsOf(mesh);
  std::vector<std::uint32_t> numberOfRoot(mesh.vertices.size(), model::kNoIndex);
  std::vector<std::uint32_t> component(mesh.vertices.size(), model::kNoIndex);
  std::vector<Bounds3> bounds;
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      std::uint32_t& number = numberOfRoot[sets.root(vertex)];
      if (number == model::kNoIndex) {
        number = static_cast<std::uint32_t>(bounds.size());
        bounds.emplace_back();
      }
      component[vertex] = number;
      bounds[number].add(mesh.vertices[vertex]);
    }
  }
  return {std::move(component), std::move(bounds)};
}

/// Splits both surfaces where their parts are apart, so that small parts far from each other are
/// not lost between the lines of one lattice. One group if there are many parts.
std::vector<Group> groupsOf(const TriangleMesh& a, const TriangleMesh& b) {
  constexpr std::size_t kMostParts = 256;
  const auto [componentOfA, boundsOfA] = partsOf(a);
  const auto [componentOfB, boundsOfB] = partsOf(b);
  std::vector<Bounds3> parts = boundsOfA;
  parts.insert(parts.end(), boundsOfB.begin(), boundsOfB.end());
  model::UnionFind sets(parts.size());
  if (parts.size() > kMostParts) {
    for (std::uint32_t i = 1; i < parts.size(); ++i) sets.unite(0, i);
  }
  // The bounds of a group grow with each part and may then reach others.
  std::vector<Bounds3> grown = parts;
  for (bool merged = parts.size() <= kMostParts; merged;) {
    merged = false;
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      for (std::uint32_t j = 0; j < i; ++j) {
        const std::uint32_t p = sets.root(i);
        const std::uint32_t q = sets.root(j);
        if (p == q || !boundsOverlap(grown[p], grown[q])) continue;
        const Bounds3 other = grown[std::max(p, q)];
        sets.unite(p, q);
        grown[sets.root(p)].add(other);
        merged = true;
      }
    }
  }
  std::map<std::uint32_t, Group> groups;
  for (std::uint32_t i = 0; i < parts.size(); ++i) groups[sets.root(i)].bounds.add(parts[i]);
  const auto share = [&](const TriangleMesh& mesh, const std::vector<std::uint32_t>& component,
                         std::size_t firstPart, TriangleMesh Group::*into) {
    std::vector<std::uint32_t> number(mesh.vertices.size(), model::kNoIndex);
    for (const Triangle& triangle : mesh.triangles) {
      const auto part = static_cast<std::uint32_t>(firstPart + component[triangle[0]]);
      TriangleMesh& target = groups[sets.root(part)].*into;
      Triangle copy{};
      for (int k = 0; k < 3; ++k) {
        std::uint32_t& found = number[triangle[k]];
        if (found == model::kNoIndex) {
          found = static_cast<std::uint32_t>(target.vertices.size());
          target.vertices.push_back(mesh.vertices[triangle[k]]);
        }
        copy[k] = found;
      }
      target.triangles.push_back(copy);
    }
  };
  share(a, componentOfA, 0, &Group::a);
  share(b, componentOfB, boundsOfA.size(), &Group::b);
  std::vector<Group> result;
  for (auto& [root, group] : groups) result.push_back(std::move(group));
  return result;
}

SolidDifference integralOf(const Group& group, const Integrand& integrand,
                           std::uint32_t resolution) {
  const Point3 middle = 0.5 * (group.bounds.min + group.bounds.max);
  std::array<double, kTurns.size()> volumes{};
  SolidDifference integral;
  for (std::size_t i = 0; i < kTurns.size(); ++i) {
    const Eigen::Matrix3d rotation = kTurns[i].normalized().toRotationMatrix();
    volumes[i] = integrate(group.a, group.b, integrand, rotation, middle, resolution);
    integral.volume += volumes[i] / static_cast<double>(kTurns.size());
  }
  for (const double volume : volumes) {
    integral.error = std::max(integral.error, 2 * std::abs(volume - integral.volume));
  }
  return integral;
}

Result<SolidDifference> integralOf(const TriangleMesh& a, const TriangleMesh& b,
                                   const Integrand& integrand,
                                   const SolidDifferenceOptions& options) {
  if (!isClosed(a)) return invalid("the first surface is not closed: it bounds no solid");
  if (!isClosed(b)) return invalid("the second surface is not closed: it bounds no solid");
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (scale.changes()) {
    auto scaled = integralOf(scale.toUnit(a), scale.toUnit(b), integrand, options);
    if (!scaled) return scaled;
    return SolidDifference{scale.fromUnit(scaled->volume, 3), scale.fromUnit(scaled->error, 3)};
  }
  SolidDifference integral;
  for (const Group& group : groupsOf(a, b)) {
    const SolidDifference part = integralOf(group, integrand, options.resolution);
    integral.volume += part.volume;
    integral.error += part.error;
  }
  return integral;
}

}  // namespace

Result<SolidDifference> solidDifference(const TriangleMesh& a, const TriangleMesh& b,
                                        const SolidDifferenceOptions& options) {
  return integralOf(a, b, kDifference, options);
}

Result<SolidDifference> solidOverlap(const TriangleMesh& a, const TriangleMesh& b,
                                     const SolidDifferenceOptions& options) {
  return integralOf(a, b, kOverlap, options);
}

}  // namespace t4d::measure
