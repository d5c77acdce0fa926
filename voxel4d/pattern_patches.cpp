#include "voxel4d/pattern_patches.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <set>

namespace t4d::voxel4d {
namespace {

/// A corner or an edge's midpoint, in doubled coordinates 0, 1, 2. Points 0 to 15 are the corners,
/// point 16 + e is the midpoint of edge e.
using Vector = std::array<int, 4>;
constexpr int kPoints = kCorners + kEdges;
using PointMask = std::uint64_t;

constexpr PointMask bit(int point) { return PointMask{1} << point; }

Vector pointOf(int point) {
  Vector p{};
  const int corner = point < kCorners ? point : edgeCorner(point - kCorners);
  for (int k = 0; k < 4; ++k) p[k] = 2 * (corner >> k & 1);
  if (point >= kCorners) p[edgeAxis(point - kCorners)] = 1;
  return p;
}

const std::array<Vector, kPoints>& points() {
  static const std::array<Vector, kPoints> all = [] {
    std::array<Vector, kPoints> made{};
    for (int i = 0; i < kPoints; ++i) made[i] = pointOf(i);
    return made;
  }();
  return all;
}

Vector minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]};
}

int dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/// n with det[m, u, v, w] = dot(m, n) for every m.
Vector cross(const Vector& u, const Vector& v, const Vector& w) {
  const auto minor = [&](int i, int j, int k) {
    return u[i] * (v[j] * w[k] - v[k] * w[j]) - u[j] * (v[i] * w[k] - v[k] * w[i]) +
           u[k] * (v[i] * w[j] - v[j] * w[i]);
  };
  return {minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)};
}

std::vector<int> pointsIn(PointMask mask) {
  std::vector<int> list;
  for (; mask != 0; mask &= mask - 1) list.push_back(std::countr_zero(mask));
  return list;
}

/// The dimension of the affine hull of some points.
int dimension(PointMask mask) {
  const std::vector<int> list = pointsIn(mask);
  std::vector<Vector> rows;
  for (std::size_t i = 1; i < list.size(); ++i) {
    rows.push_back(minus(points()[list[i]], points()[list[0]]));
  }
  int rank = 0;
  for (int column = 0; column < 4; ++column) {
    std::size_t pivot = rank;
    while (pivot < rows.size() && rows[pivot][column] == 0) ++pivot;
    if (pivot == rows.size()) continue;
    std::swap(rows[rank], rows[pivot]);
    for (std::size_t i = rank + 1; i < rows.size(); ++i) {
      const int a = rows[rank][column];
      const int b = rows[i][column];
      int divisor = 0;
      for (int k = 0; k < 4; ++k) {
        rows[i][k] = rows[i][k] * a - rows[rank][k] * b;
        divisor = std::gcd(divisor, rows[i][k]);
      }
      for (int k = 0; k < 4 && divisor > 1; ++k) rows[i][k] /= divisor;
    }
    ++rank;
  }
  return rank;
}

/// A hyperplane through four of the points, and the side of it on which each point lies.
struct Hyperplane {
  PointMask on = 0;
  PointMask below = 0;
  PointMask above = 0;
  bool boundary = false;  // of the hypercube
};

/// Every hyperplane spanned by four of the 48 points. The facets of all hulls lie in these.
std::vector<Hyperplane> spannedHyperplanes() {
  std::set<std::array<int, 5>> seen;
  std::vector<Hyperplane> all;
  const auto& p = points();
  for (int a = 0; a < kPoints; ++a) {
    for (int b = a + 1; b < kPoints; ++b) {
      for (int c = b + 1; c < kPoints; ++c) {
        for (int d = c + 1; d < kPoints; ++d) {
          Vector n = cross(minus(p[b], p[a]), minus(p[c], p[a]), minus(p[d], p[a]));
          int divisor = std::gcd(std::gcd(n[0], n[1]), std::gcd(n[2], n[3]));
          if (divisor == 0) continue;
          // Normalizes the sign of a normal: its first non-zero component is positive.
          if (n < Vector{}) divisor = -divisor;
          for (int& k : n) k /= divisor;
          const int offset = dot(n, p[a]);
          if (!seen.insert({n[0], n[1], n[2], n[3], offset}).second) continue;
          Hyperplane plane;
          for (int i = 0; i < kPoints; ++i) {
            const int side = dot(n, p[i]) - offset;
            (side == 0 ? plane.on : side < 0 ? plane.below : plane.above) |= bit(i);
          }
          plane.boundary = plane.below == 0 || plane.above == 0;
          all.push_back(plane);
        }
      }
    }
  }
  return all;
}

/// Inside corners and the midpoints of the edges between inside and outside.
PointMask hullPoints(unsigned pattern) {
  return pattern | PointMask{PatternTable::edges(pattern)} << kCorners;
}

/// The vertices of a convex polygon in cyclic order.
std::vector<int> inCyclicOrder(PointMask mask) {
  std::vector<int> list = pointsIn(mask);
  const Vector& origin = points()[list[0]];
  // Two coordinates in which the polygon does not collapse to a line.
  int i = 0;
  int j = 0;
  const auto spansPlane = [&](int a, int b) {
    for (std::size_t k = 2; k < list.size(); ++k) {
      const Vector u = minus(points()[list[1]], origin);
      const Vector v = minus(points()[list[k]], origin);
      if (u[a] * v[b] - u[b] * v[a] != 0) return true;
    }
    return false;
  };
  for (int a = 0; a < 4; ++a) {
    for (int b = a + 1; b < 4; ++b) {
      if (spansPlane(a, b)) {
        i = a;
        j = b;
      }
    }
  }
  // Angles around the centroid (times the number of points). Directions to distinct vertices of
  // these few small polygons are far apart, so floating-point angles order them reliably.
  const int n = static_cast<int>(list.size());
  int sumI = 0;
  int sumJ = 0;
  for (const int point : list) {
    sumI += points()[point][i];
    sumJ += points()[point][j];
  }
  const auto angle = [&](int point) {
    return std::atan2(n * points()[point][j] - sumJ, n * points()[point][i] - sumI);
  };
  std::sort(list.begin(), list.end(), [&](int a, int b) { return angle(a) < angle(b); });
  return list;
}

/// A facet of the patch, given by its 2-faces: convex polygons of points.
using Polytope = std::vector<std::vector<int>>;

/// The patch of one pattern, not yet cut into tetrahedra.
std::vector<Polytope> patchOf(unsigned pattern, const std::vector<Hyperplane>& hyperplanes) {
  const PointMask hull = hullPoints(pattern);
  struct Facet {
    PointMask points;
    bool boundary;
  };
  std::vector<Facet> facets;
  for (const Hyperplane& plane : hyperplanes) {
    if ((hull & plane.below) != 0 && (hull & plane.above) != 0) continue;
    const PointMask on = hull & plane.on;
    if (std::popcount(on) < 4 || dimension(on) != 3) continue;
    facets.push_back({on, plane.boundary});
  }
  std::vector<Polytope> patch;
  for (const Facet& facet : facets) {
    if (facet.boundary) continue;
    assert((facet.points & ((PointMask{1} << kCorners) - 1)) == 0);
    std::set<PointMask> faces;
    for (const Facet& other : facets) {
      const PointMask common = facet.points & other.points;
      if (&other != &facet && std::popcount(common) >= 3 && dimension(common) == 2) {
        faces.insert(common);
      }
    }
    Polytope polytope;
    for (const PointMask face : faces) polytope.push_back(inCyclicOrder(face));
    patch.push_back(std::move(polytope));
  }
  return patch;
}

/// A symmetry of the hypercube, as a permutation of the 48 points.
using Symmetry = std::array<std::uint8_t, kPoints>;

/// All 384 symmetries: permutations of the axes, each axis reversed or not.
std::vector<Symmetry> symmetries() {
  std::map<Vector, int> number;
  for (int i = 0; i < kPoints; ++i) number[points()[i]] = i;
  std::vector<Symmetry> all;
  std::array<int, 4> axes = {0, 1, 2, 3};
  do {
    for (int reversed = 0; reversed < 16; ++reversed) {
      Symmetry symmetry{};
      for (int i = 0; i < kPoints; ++i) {
        Vector image{};
        for (int k = 0; k < 4; ++k) {
          const int value = points()[i][axes[k]];
          image[k] = (reversed >> k & 1) != 0 ? 2 - value : value;
        }
        symmetry[i] = static_cast<std::uint8_t>(number.at(image));
      }
      all.push_back(symmetry);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  return all;
}

unsigned imageOf(unsigned pattern, const Symmetry& symmetry) {
  unsigned image = 0;
  for (int corner = 0; corner < kCorners; ++corner) {
    if ((pattern >> corner & 1U) != 0) image |= 1U << symmetry[corner];
  }
  return image;
}

/// The rank of each point in the pulling order: lexicographic by (t, z, y, x).
std::array<int, kPoints> pullingOrder() {
  std::array<int, kPoints> order{};
  for (int i = 0; i < kPoints; ++i) {
    const Vector& p = points()[i];
    order[i] = ((p[3] * 3 + p[2]) * 3 + p[1]) * 3 + p[0];
  }
  return order;
}

/// The pulling triangulation of the image of a patch under a symmetry.
class PullingTriangulation {
 public:
  void add(unsigned pattern, const std::vector<Polytope>& patch, const Symmetry& symmetry,
           std::vector<PatternTable::Tetrahedron>& into) {
    inside_ = points()[std::countr_zero(pattern)];
    for (const Polytope& polytope : patch) {
      int apex = -1;
      for (const auto& face : polytope) {
        for (const int point : face) {
          const int image = symmetry[point];
          if (apex < 0 || order_[image] < order_[apex]) apex = image;
        }
      }
      for (const auto& face : polytope) fan(face, symmetry, apex, into);
    }
  }

 private:
  void fan(const std::vector<int>& face, const Symmetry& symmetry, int apex,
           std::vector<PatternTable::Tetrahedron>& into) {
    const std::size_t n = face.size();
    std::size_t smallest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (symmetry[face[i]] == apex) return;
      if (order_[symmetry[face[i]]] < order_[symmetry[face[smallest]]]) smallest = i;
    }
    const int first = symmetry[face[smallest]];
    for (std::size_t i = 1; i + 1 < n; ++i) {
      int b = symmetry[face[(smallest + i) % n]];
      int c = symmetry[face[(smallest + i + 1) % n]];
      const auto& p = points();
      // An inside corner lies on the inner side of every facet of the hull.
      const int side =
          dot(minus(inside_, p[apex]),
              cross(minus(p[first], p[apex]), minus(p[b], p[apex]), minus(p[c], p[apex])));
      assert(side != 0);
      if (side > 0) std::swap(b, c);
      const auto edge = [](int point) { return static_cast<std::uint8_t>(point - kCorners); };
      into.push_back({edge(apex), edge(first), edge(b), edge(c)});
    }
  }

  std::array<int, kPoints> order_ = pullingOrder();
  Vector inside_{};
};

}  // namespace

PatternPatches computePatternPatches() {
  const std::vector<Hyperplane> hyperplanes = spannedHyperplanes();
  const std::vector<Symmetry> group = symmetries();
  // Patches of one representative pattern of each class; every other pattern is the image of one.
  std::vector<std::vector<Polytope>> patches;
  struct Image {
    int patch = -1;
    std::uint16_t symmetry = 0;
  };
  std::vector<Image> images(kPatterns);
  for (unsigned pattern = 0; pattern < kPatterns; ++pattern) {
    if (images[pattern].patch >= 0) continue;
    for (std::size_t s = 0; s < group.size(); ++s) {
      images[imageOf(pattern, group[s])] = {static_cast<int>(patches.size()),
                                            static_cast<std::uint16_t>(s)};
    }
    const bool mixed = pattern != 0 && pattern != kPatterns - 1;
    patches.push_back(mixed ? patchOf(pattern, hyperplanes) : std::vector<Polytope>());
  }

  PatternPatches all;
  all.classCount = static_cast<int>(patches.size());
  PullingTriangulation triangulation;
  all.first.push_back(0);
  for (unsigned pattern = 0; pattern < kPatterns; ++pattern) {
    const Image& image = images[pattern];
    if (!patches[image.patch].empty()) {
      triangulation.add(pattern, patches[image.patch], group[image.symmetry], all.tetrahedra);
    }
    all.first.push_back(static_cast<std::uint32_t>(all.tetrahedra.size()));
  }
  return all;
}

}  // namespace t4d::voxel4d
