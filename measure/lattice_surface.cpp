#include "measure/lattice_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

#include "model/parallel.h"

namespace t4d::measure {
namespace {

using model::Point3;

// A corner of a cube has the number x + 2 y + 4 z; an edge the number 4 * axis plus those of the
// coordinates of the next two axes; a face 2 * axis plus its coordinate.

constexpr int edgeNumber(int axis, int corner) {
  return 4 * axis + (corner >> (axis + 1) % 3 & 1) + 2 * (corner >> (axis + 2) % 3 & 1);
}

/// The corner at the lower end of an edge.
constexpr int lowCorner(int edge) {
  const int axis = edge / 4;
  return (edge & 1) << (axis + 1) % 3 | (edge >> 1 & 1) << (axis + 2) % 3;
}

/// How a cube is cut, depending on which of its corners are inside (bits).
struct CubePattern {
  struct Segment {
    std::uint8_t edge;  // where it begins
    std::uint8_t face;
  };
  std::vector<std::vector<Segment>> loops;  // solid on the right, seen from outside the cube
  std::array<std::uint8_t, 6> segmentsOnFace = {};
};

CubePattern patternOf(unsigned inside) {
  CubePattern pattern;
  std::array<int, 12> next;
  std::array<std::uint8_t, 12> face{};
  next.fill(-1);
  for (int f = 0; f < 6; ++f) {
    const int axis = f / 2;
    const int u = 1 << (axis + 1) % 3;
    const int v = 1 << (axis + 2) % 3;
    const int base = (f % 2) << axis;
    // Counter-clockwise seen from outside the cube.
    std::array<int, 4> corners = {base, base | u, base | u | v, base | v};
    if (f % 2 == 0) std::swap(corners[1], corners[3]);
    const auto isInside = [&](int i) { return (inside >> corners[i % 4] & 1) != 0; };
    const auto edgeAfter = [&](int i) {
      const int a = corners[i % 4];
      const int b = corners[(i + 1) % 4];
      const int along = a ^ b;
      return edgeNumber(along == 1 ? 0 : along == 2 ? 1 : 2, std::min(a, b));
    };
    for (int i = 0; i < 4; ++i) {
      if (isInside(i) || !isInside(i + 1)) continue;
      int last = i + 1;
      while (isInside(last + 1)) ++last;
      next[edgeAfter(i)] = edgeAfter(last);
      face[edgeAfter(i)] = static_cast<std::uint8_t>(f);
      ++pattern.segmentsOnFace[f];
    }
  }
  for (int start = 0; start < 12; ++start) {
    if (next[start] < 0) continue;
    std::vector<CubePattern::Segment> loop;
    for (int edge = start; next[edge] >= 0;) {
      loop.push_back({static_cast<std::uint8_t>(edge), face[edge]});
      edge = std::exchange(next[edge], -1);
    }
    pattern.loops.push_back(std::move(loop));
  }
  return pattern;
}

const std::array<CubePattern, 256>& patterns() {
  static const std::array<CubePattern, 256> kPatterns = [] {
    std::array<CubePattern, 256> all;
    for (unsigned inside = 0; inside < 256; ++inside) all[inside] = patternOf(inside);
    return all;
  }();
  return kPatterns;
}

// Planes whose normals differ by more than this meet in an edge.
constexpr double kSharpCosine = 0.9;
// Directions in which the planes tell less than this part of what they tell in the best one say
// nothing.
constexpr double kTold = 0.03;

/// The point in the cube [0, 1]^3 that is nearest to planes, and nearest to `middle` among those
/// that are about as near.
Point3 nearestToPlanes(std::span<const Point3> points, std::span<const Point3> normals,
                       const Point3& middle) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Point3 b = Point3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    a += normals[i] * normals[i].transpose();
    b += normals[i] * normals[i].dot(points[i] - middle);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(a);
  Point3 offset = Point3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value < kTold * eigen.eigenvalues()[2]) continue;
    offset += eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(b) / value);
  }
  constexpr double kLow = LatticeSurface::kMargin;
  constexpr double kHigh = 1 - kLow;
  const auto isWithin = [&](const Point3& p) {
    return (p.array() >= kLow).all() && (p.array() <= kHigh).all();
  };
  if (isWithin(middle + offset)) return middle + offset;
  // The least of the same sum of squares within the cube, one coordinate after another; a small
  // part of the distance from the middle makes it unique.
  a += 1e-3 * a.trace() * Eigen::Matrix3d::Identity();
  Point3 point = (middle + offset).cwiseMax(kLow).cwiseMin(kHigh);
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 3; ++i) {
      const Point3 d = point - middle;
      const double rest = a.row(i).dot(d) - a(i, i) * d[i];
      point[i] = std::clamp(middle[i] + (b[i] - rest) / a(i, i), kLow, kHigh);
    }
  }
  return point;
}

}  // namespace

LatticeSurface::LatticeSurface(const VisitLattice& visits)
    : visits_(visits), lattice_(visits_.lattice()) {
  addCones();
  setApexes();
  setTriangles();
}

Point3 LatticeSurface::placeAt(std::uint64_t cube, const Point3& fraction) const {
  const LatticeIndex index = indexOf(cube);
  Point3 place;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = lattice_.at[axis][index[axis]];
    place[axis] = low + fraction[axis] * (lattice_.at[axis][index[axis] + 1] - low);
  }
  return place;
}

void LatticeSurface::addCones() {
  std::array<std::uint32_t, 4> firsts = {0, 0, 0, 0};
  std::vector<std::uint64_t> cubes;
  for (int axis = 0; axis < 3; ++axis) {
    const auto crossings = visits_.crossings(axis);
    firsts[axis + 1] = firsts[axis] + static_cast<std::uint32_t>(crossings.size());
    const std::uint64_t u = keyOf({axis == 2, axis == 0, axis == 1});
    const std::uint64_t v = keyOf({axis == 1, axis == 2, axis == 0});
    for (const LatticeCrossing& crossing : crossings) {
      // No crossing is at the boundary of the lattice.
      for (const std::uint64_t back : {std::uint64_t{0}, u, v, u + v}) {
        cubes.push_back(crossing.key - back);
      }
      Point3 fraction = Point3::Zero();
      fraction[axis] = std::clamp(crossing.fraction, kMargin, 1 - kMargin);
      mesh_.vertices.push_back(placeAt(crossing.key, fraction));
    }
  }
  firstApex_ = firsts[3];
  std::ranges::sort(cubes);
  cubes.erase(std::ranges::unique(cubes).begin(), cubes.end());

  for (const std::uint64_t cube : cubes) {
    const LatticeIndex low = indexOf(cube);
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const LatticeIndex at = {low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                               low[2] + (corner >> 2 & 1)};
      if (visits_.isInside(at)) inside |= 1U << corner;
    }
    const CubePattern& pattern = patterns()[inside];
    for (const auto& loop : pattern.loops) {
      cones_.push_back({cube, static_cast<std::uint32_t>(loops_.size()),
                        static_cast<std::uint8_t>(loop.size()), pattern.loops.size() == 1, false,
                        false});
      for (const auto& [edge, face] : loop) {
        const int axis = edge / 4;
        const int corner = lowCorner(edge);
        const std::uint64_t key =
            keyOf({low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2 & 1)});
        const auto crossings = visits_.crossings(axis);
        const auto at = std::ranges::lower_bound(crossings, key, {}, &LatticeCrossing::key);
        loops_.push_back(firsts[axis] + static_cast<std::uint32_t>(at - crossings.begin()));
        // A face with two segments is not replaced.
        faces_.push_back(pattern.segmentsOnFace[face] == 1 ? face : 6);
      }
    }
  }
}

void LatticeSurface::setApexes() {
  mesh_.vertices.resize(firstApex_ + cones_.size());
  const std::size_t xEnd = visits_.crossings(0).size();
  const std::size_t yEnd = xEnd + visits_.crossings(1).size();
  model::forEach(cones_.size(), [&](std::size_t c) {
    Cone& cone = cones_[c];
    std::array<Point3, 12> points;
    std::array<Point3, 12> normals;
    Point3 middle = Point3::Zero();
    double least = 1;
    for (int i = 0; i < cone.size; ++i) {
      const std::uint32_t vertex = loops_[cone.first + i];
      const int axis = vertex < xEnd ? 0 : vertex < yEnd ? 1 : 2;
      const std::size_t first = axis == 0 ? 0 : axis == 1 ? xEnd : yEnd;
      const LatticeCrossing& crossing = visits_.crossings(axis)[vertex - first];
      const LatticeIndex own = indexOf(crossing.key);
      const LatticeIndex cube = indexOf(cone.cube);
      for (int k = 0; k < 3; ++k) points[i][k] = own[k] - cube[k];
      middle += points[i] / cone.size;
      middle[axis] += std::clamp(crossing.fraction, kMargin, 1 - kMargin) / cone.size;
      points[i][axis] += crossing.fraction;
      normals[i] = crossing.normal;
      for (int k = 0; k < i; ++k) least = std::min(least, normals[i].dot(normals[k]));
    }
    cone.sharp = cone.alone && least < kSharpCosine;
    if (cone.alone && !cone.plain) {
      const auto count = static_cast<std::size_t>(cone.size);
      middle =
          nearestToPlanes(std::span(points).first(count), std::span(normals).first(count), middle);
    }
    mesh_.vertices[firstApex_ + c] = placeAt(cone.cube, middle);
  });
}

std::uint32_t LatticeSurface::coneAcross(const Cone& cone, int face) const {
  LatticeIndex index = indexOf(cone.cube);
  index[face / 2] += face % 2 == 0 ? -1 : 1;
  const auto at = std::ranges::lower_bound(cones_, keyOf(index), {}, &Cone::cube);
  return static_cast<std::uint32_t>(at - cones_.begin());
}

/// Whether the segment on a face of a cube, the upper one along an axis, is replaced by one between
/// the apexes.
bool LatticeSurface::isReplaced(const Cone& cone, const Cone& other, int face) const {
  if (!cone.sharp || !other.sharp || cone.plain || other.plain) return false;
  const int axis = face / 2;
  const Point3& a = mesh_.vertices[firstApex_ + (&cone - cones_.data())];
  const Point3& b = mesh_.vertices[firstApex_ + (&other - cones_.data())];
  const LatticeIndex index = indexOf(cone.cube);
  const double plane = lattice_.at[axis][index[axis] + 1];
  const Point3 meeting = a + (b - a) * ((plane - a[axis]) / (b[axis] - a[axis]));
  for (const int k : {(axis + 1) % 3, (axis + 2) % 3}) {
    const double margin = kMargin * lattice_.spacing;
    if (!(meeting[k] > lattice_.at[k][index[k]] + margin) ||
        !(meeting[k] < lattice_.at[k][index[k] + 1] - margin)) {
      return false;
    }
  }
  return true;
}

void LatticeSurface::setTriangles() {
  mesh_.triangles.clear();
  coneOf_.clear();
  for (std::uint32_t c = 0; c < cones_.size(); ++c) {
    const Cone& cone = cones_[c];
    const std::uint32_t apex = firstApex_ + c;
    const auto add = [&](const model::Triangle& triangle) {
      mesh_.triangles.push_back(triangle);
      coneOf_.push_back(c);
    };
    for (int i = 0; i < cone.size; ++i) {
      const std::uint32_t from = loops_[cone.first + i];
      const std::uint32_t to = loops_[cone.first + (i + 1) % cone.size];
      const int face = faces_[cone.first + i];
      if (face < 6 && cone.sharp) {
        // The cube below the face adds the two triangles.
        const std::uint32_t other = coneAcross(cone, face);
        const bool isUpper = face % 2 == 1;
        if (isReplaced(cones_[isUpper ? c : other], cones_[isUpper ? other : c], face | 1)) {
          if (isUpper) {
            add({apex, from, firstApex_ + other});
            add({firstApex_ + other, to, apex});
          }
          continue;
        }
      }
      add({apex, from, to});
    }
  }
}

bool LatticeSurface::makePlain(std::span<const std::uint32_t> triangles) {
  bool changed = false;
  const auto flatten = [&](Cone& cone) {
    changed = changed || !cone.plain;
    cone.plain = true;
  };
  for (const std::uint32_t triangle : triangles) {
    Cone& cone = cones_[coneOf_[triangle]];
    flatten(cone);
    for (int i = 0; i < cone.size; ++i) {
      const int face = faces_[cone.first + i];
      if (face < 6) flatten(cones_[coneAcross(cone, face)]);
    }
  }
  if (changed) {
    setApexes();
    setTriangles();
  }
  return changed;
}

}  // namespace t4d::measure
