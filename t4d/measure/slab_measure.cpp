#include "t4d/measure/slab_measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>

namespace t4d::measure {
namespace {

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Quadruple;
#else
using Quadruple = long double;  // has 113 bits where there is no other such type
#endif

/// The flux of (x, y, z, 0) through a cell, times 24, and what bounds its rounding.
template <class Real>
struct Flux {
  std::array<Real, 4> normal;  // outward, with a length of six times the cell's 3-measure
  Real value;
  Real magnitude;  // the sum of the terms' magnitudes
};

/// The normal n of the cell has det[m, u, v, w] = m . n for every m, where u, v and w are the edges
/// from its corner a.
template <class Real>
Flux<Real> fluxThrough(const model::Slab& slab, const model::Cell& cell,
                       const model::Point4& origin) {
  using Vector = std::array<Real, 4>;
  const auto difference = [](const model::Point4& to, const model::Point4& from) {
    Vector edge;
    for (int k = 0; k < 4; ++k) edge[k] = static_cast<Real>(to[k]) - static_cast<Real>(from[k]);
    return edge;
  };
  const model::Point4& corner = slab.vertices[cell[0]];
  const Vector u = difference(slab.vertices[cell[1]], corner);
  const Vector v = difference(slab.vertices[cell[2]], corner);
  const Vector w = difference(slab.vertices[cell[3]], corner);
  const Vector a = difference(corner, origin);
  const Real vw01 = v[0] * w[1] - v[1] * w[0];
  const Real vw02 = v[0] * w[2] - v[2] * w[0];
  const Real vw03 = v[0] * w[3] - v[3] * w[0];
  const Real vw12 = v[1] * w[2] - v[2] * w[1];
  const Real vw13 = v[1] * w[3] - v[3] * w[1];
  const Real vw23 = v[2] * w[3] - v[3] * w[2];
  Flux<Real> flux;
  flux.normal = {
      u[1] * vw23 - u[2] * vw13 + u[3] * vw12, -(u[0] * vw23 - u[2] * vw03 + u[3] * vw02),
      u[0] * vw13 - u[1] * vw03 + u[3] * vw01, -(u[0] * vw12 - u[1] * vw02 + u[2] * vw01)};
  // The centroid is a + (u + v + w) / 4.
  flux.value = 0;
  flux.magnitude = 0;
  const auto size = [](Real value) { return value < 0 ? -value : value; };
  const Real longest =
      std::max({size(u[0]) + size(u[1]) + size(u[2]), size(v[0]) + size(v[1]) + size(v[2]),
                size(w[0]) + size(w[1]) + size(w[2])});
  for (int k = 0; k < 3; ++k) {
    const Real fourfold = 4 * a[k] + u[k] + v[k] + w[k];
    flux.value += flux.normal[k] * fourfold;
    flux.magnitude += size(fourfold);
  }
  // Each product in the spatial components of the normal has one time and two lengths.
  flux.magnitude *= longest * longest * (size(u[3]) + size(v[3]) + size(w[3]));
  return flux;
}

/// Whether no component of the normal exceeds what moving the corners by `rounding` can change in
/// it: for each axis the rounding times the area of a side, seen along that axis and the
/// component's.
bool isFlat(const model::Slab& slab, const model::Cell& cell, const std::array<double, 4>& normal,
            const model::Point4& rounding) {
  const model::Point4& a = slab.vertices[cell[0]];
  const std::array<Eigen::Vector4d, 3> edges = {
      slab.vertices[cell[1]] - a, slab.vertices[cell[2]] - a, slab.vertices[cell[3]] - a};
  const Eigen::Vector4d extent =
      edges[0].cwiseAbs().cwiseMax(edges[1].cwiseAbs()).cwiseMax(edges[2].cwiseAbs());
  const auto allWithin = [&](auto areaAlong) {
    for (int k = 0; k < 4; ++k) {
      double most = 0;
      for (int j = 0; j < 4; ++j) {
        if (j == k) continue;
        int others[2];
        int found = 0;
        for (int axis = 0; axis < 4; ++axis) {
          if (axis != j && axis != k) others[found++] = axis;
        }
        most += rounding[j] * areaAlong(others[0], others[1]);
      }
      if (std::abs(normal[k]) > most) return false;
    }
    return true;
  };
  if (!allWithin([&](int l, int m) { return 2 * extent[l] * extent[m]; })) return false;
  return allWithin([&](int l, int m) {
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector4d& u = edges[i];
      const Eigen::Vector4d& v = edges[(i + 1) % 3];
      largest = std::max(largest, std::abs(u[l] * v[m] - u[m] * v[l]));
    }
    return largest;
  });
}

}  // namespace

SlabMeasure measureOf(const model::Slab& slab, const model::Point4& rounding) {
  SlabMeasure measured;
  if (slab.vertices.empty()) return measured;
  const model::Point4& origin = slab.vertices.front();
  const std::vector<model::Cell>& cells = slab.connectivity->cells;
  // Sums of fixed pieces do not depend on the number of threads.
  constexpr std::size_t kPiece = 16384;
  struct Piece {
    double flux72 = 0;
    double magnitude = 0;
    double measure6 = 0;
    std::vector<std::uint32_t> flat;
  };
  std::vector<Piece> pieces((cells.size() + kPiece - 1) / kPiece);
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t number) {
    Piece& piece = pieces[number];
    const std::size_t end = std::min(cells.size(), (number + 1) * kPiece);
    for (std::size_t i = number * kPiece; i < end; ++i) {
      const auto flux = fluxThrough<double>(slab, cells[i], origin);
      piece.flux72 += flux.value;
      piece.magnitude += flux.magnitude;
      piece.measure6 += Eigen::Map<const Eigen::Vector4d>(flux.normal.data()).stableNorm();
      if (isFlat(slab, cells[i], flux.normal, rounding)) {
        piece.flat.push_back(static_cast<std::uint32_t>(i));
      }
    }
  });
  double flux72 = 0;
  double magnitude = 0;
  double measure6 = 0;
  for (const Piece& piece : pieces) {
    flux72 += piece.flux72;
    magnitude += piece.magnitude;
    measure6 += piece.measure6;
    measured.flat.insert(measured.flat.end(), piece.flat.begin(), piece.flat.end());
  }
  // Rounding leaves this part of the value unknown.
  constexpr double kUnknown = 1e-10;
  if (std::numeric_limits<double>::epsilon() * magnitude > kUnknown * std::abs(flux72)) {
    Quadruple sum = 0;
    for (const model::Cell& cell : cells) sum += fluxThrough<Quadruple>(slab, cell, origin).value;
    flux72 = static_cast<double>(sum);
  }
  measured.hypervolume = flux72 / 72;
  measured.boundaryVolume = measure6 / 6;
  return measured;
}

}  // namespace t4d::measure
