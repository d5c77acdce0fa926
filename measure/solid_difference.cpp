#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "measure/common_parts.h"
#include "measure/components.h"
#include "model/surface_components.h"
#include "model/unit_scale.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

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

/// A rotation about a point.
struct Turn {
  Eigen::Matrix3d rotation;
  Point3 middle;

  Point3 operator()(const Point3& point) const { return rotation * (point - middle); }
};

/// The part of a line parallel to z that lies in a box, before a turn about a point.
class BoxAlongLines {
 public:
  BoxAlongLines(const Bounds3& box, const Turn& turn)
      : min_(box.min - turn.middle),
        max_(box.max - turn.middle),
        back_(turn.rotation.transpose()) {}

  /// The length of z from `low` to `high` that is in it.
  double lengthOf(double x, double y, double low, double high) const {
    const Point3 start = back_ * Point3(x, y, 0);
    for (int axis = 0; axis < 3; ++axis) {
      // No line is parallel to a face: the rotations are askew.
      const double p = (min_[axis] - start[axis]) / back_(axis, 2);
      const double q = (max_[axis] - start[axis]) / back_(axis, 2);
      low = std::max(low, std::min(p, q));
      high = std::min(high, std::max(p, q));
    }
    return std::max(0.0, high - low);
  }

 private:
  Point3 min_;
  Point3 max_;
  Eigen::Matrix3d back_;
};

std::vector<Point3> turned(std::span<const Point3> points, const Turn& turn) {
  std::vector<Point3> all;
  all.reserve(points.size());
  for (const Point3& point : points) all.push_back(turn(point));
  return all;
}

/// A mesh in the lattice's coordinates, with its triangles sorted into the rows they may meet.
class Rows {
 public:
  /// `points` are those of the mesh, turned.
  Rows(const TriangleMesh& mesh, const std::vector<Point3>& points, const Lattice& lattice)
      : mesh_(mesh), points_(points), starts_(static_cast<std::size_t>(lattice.rows) + 1) {
    const double right = lattice.x(lattice.columns);
    const double above = lattice.y(lattice.rows);
    const auto eachRow = [&](const Triangle& triangle, auto visit) {
      const Point3& a = points_[triangle[0]];
      const Point3& b = points_[triangle[1]];
      const Point3& c = points_[triangle[2]];
      const auto [low, high] = std::minmax({a.y(), b.y(), c.y()});
      const auto [left, end] = std::minmax({a.x(), b.x(), c.x()});
      // No line goes through it.
      if (high < lattice.y0 || low > above || end < lattice.x0 || left > right) return;
      const std::int64_t last = std::min(lattice.rows, lattice.rowFrom(high) + 1);
      for (std::int64_t row = std::max<std::int64_t>(0, lattice.rowFrom(low) - 1); row < last;
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
  const std::vector<Point3>& points_;
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
using Integrand = std::int64_t (*)(std::int64_t a, std::int64_t b);

std::int64_t inOne(std::int64_t a, std::int64_t b) { return std::abs(a - b); }
std::int64_t inBoth(std::int64_t a, std::int64_t b) {
  return std::max<std::int64_t>(0, std::min(a, b));
}

/// A mesh whose points were turned.
struct Turned {
  Turned(const TriangleMesh& given, const Turn& turn)
      : mesh(given), points(turned(given.vertices, turn)) {}

  const TriangleMesh& mesh;
  std::vector<Point3> points;
};

/// The integral along lines that are parallel to z and go through these bounds; with a box, of what
/// is in it.
double integrate(const Turned& a, const Turned& b, Integrand integrand, const Bounds3& bounds,
                 std::uint32_t resolution, const BoxAlongLines* box = nullptr) {
  if (bounds.empty() || !((bounds.max - bounds.min).head<2>().maxCoeff() > 0)) return 0;
  const Lattice lattice = latticeOver(bounds, resolution);
  const Rows rowsOfA(a.mesh, a.points, lattice);
  const Rows rowsOfB(b.mesh, b.points, lattice);
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
      const std::int64_t value = integrand(windingOfA, windingOfB);
      if (value == 0) continue;
      const double low = hits[i].z;
      const double high = hits[i + 1].z;
      const double length =
          box == nullptr ? high - low
                         : box->lengthOf(lattice.x(hits[i].column), lattice.y(row), low, high);
      sum += static_cast<double>(value) * length;
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

Eigen::Matrix3d rotationOf(std::size_t turn) {
  return kTurns[turn].normalized().toRotationMatrix();
}

/// The mean of four integrals.
SolidDifference meanOf(const std::array<double, kTurns.size()>& volumes) {
  SolidDifference mean;
  for (const double volume : volumes) mean.volume += volume / static_cast<double>(volumes.size());
  for (const double volume : volumes) {
    mean.error = std::max(mean.error, 2 * std::abs(volume - mean.volume));
  }
  return mean;
}

void add(const SolidDifference& part, SolidDifference& sum) {
  sum.volume += part.volume;
  sum.error += part.error;
}

Bounds3 boundsOfPoints(std::span<const Point3> points) {
  Bounds3 bounds;
  for (const Point3& point : points) bounds.add(point);
  return bounds;
}

SolidDifference differenceIn(const Group& group, std::uint32_t resolution) {
  std::array<double, kTurns.size()> volumes{};
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const Turn turn{rotationOf(i), 0.5 * (group.bounds.min + group.bounds.max)};
    const Turned a(group.a, turn);
    const Turned b(group.b, turn);
    Bounds3 bounds = boundsOfPoints(a.points);
    bounds.add(boundsOfPoints(b.points));
    volumes[i] = integrate(a, b, inOne, bounds, resolution);
  }
  return meanOf(volumes);
}

SolidDifference differenceOf(const TriangleMesh& a, const TriangleMesh& b,
                             const SolidDifferenceOptions& options) {
  SolidDifference sum;
  for (const Group& group : groupsOf(a, b)) add(differenceIn(group, options.resolution), sum);
  return sum;
}

/// The bounds of a part, somewhat larger, and still apart from those of others.
Bounds3 boxAbout(const CommonPart& part) {
  const Point3 margin = (part.bounds.max - part.bounds.min) * (kLeastGapOfParts / 4);
  return {part.bounds.min - margin, part.bounds.max + margin};
}

/// Each part has lattices of its own, which together have about as many lines as one.
SolidDifference overlapOf(const TriangleMesh& a, const TriangleMesh& b,
                          const SolidDifferenceOptions& options) {
  constexpr double kLeastLines = 16;
  const std::vector<CommonPart> parts = commonParts(a, b);
  Bounds3 bounds;
  for (const CommonPart& part : parts) bounds.add(part.bounds);
  const double share = options.resolution / std::sqrt(static_cast<double>(parts.size()));
  const auto resolution = static_cast<std::uint32_t>(std::max(kLeastLines, share));
  std::vector<std::array<double, kTurns.size()>> volumes(parts.size());
  for (std::size_t i = 0; i < kTurns.size() && !parts.empty(); ++i) {
    const Turn turn{rotationOf(i), 0.5 * (bounds.min + bounds.max)};
    const Turned turnedA(a, turn);
    const Turned turnedB(b, turn);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Bounds3 ofPart = boundsOfPoints(turned(parts[k].corners, turn));
      const BoxAlongLines box(boxAbout(parts[k]), turn);
      volumes[k][i] = integrate(turnedA, turnedB, inBoth, ofPart, resolution,
                                parts.size() > 1 ? &box : nullptr);
    }
  }
  SolidDifference sum;
  for (const auto& ofPart : volumes) add(meanOf(ofPart), sum);
  return sum;
}

using Measure = SolidDifference (*)(const TriangleMesh& a, const TriangleMesh& b,
                                    const SolidDifferenceOptions& options);

Result<SolidDifference> measuredInUnits(const TriangleMesh& a, const TriangleMesh& b,
                                        Measure measure, const SolidDifferenceOptions& options) {
  if (!isClosed(a)) return invalid("the first surface is not closed: it bounds no solid");
  if (!isClosed(b)) return invalid("the second surface is not closed: it bounds no solid");
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (!scale.changes()) return measure(a, b, options);
  const SolidDifference scaled = measure(scale.toUnit(a), scale.toUnit(b), options);
  return SolidDifference{scale.fromUnit(scaled.volume, 3), scale.fromUnit(scaled.error, 3)};
}

}  // namespace

Result<SolidDifference> solidDifference(const TriangleMesh& a, const TriangleMesh& b,
                                        const SolidDifferenceOptions& options) {
  return measuredInUnits(a, b, differenceOf, options);
}

Result<SolidDifference> solidOverlap(const TriangleMesh& a, const TriangleMesh& b,
                                     const SolidDifferenceOptions& options) {
  return measuredInUnits(a, b, overlapOf, options);
}

}  // namespace t4d::measure
