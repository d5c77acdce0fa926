#include "measure/slab_measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/exact_sum.h"
#include "model/parallel.h"
#include "model/unit_scale.h"

namespace t4d::measure {
namespace {

/// The flux of (x, y, z, 0) through a cell, times 24, and what bounds its rounding.
struct Flux {
  std::array<double, 4> normal;  // outward, with a length of six times the cell's 3-measure
  double value;
  double magnitude;  // the sum of the terms' magnitudes
};

/// The normal n of the cell has det[m, u, v, w] = m . n for every m, where u, v and w are the edges
/// from its corner a.
Flux fluxThrough(const model::Slab& slab, const model::Cell& cell, const model::Point4& origin) {
  const model::Point4& corner = slab.vertices[cell[0]];
  const model::Point4 u = slab.vertices[cell[1]] - corner;
  const model::Point4 v = slab.vertices[cell[2]] - corner;
  const model::Point4 w = slab.vertices[cell[3]] - corner;
  const model::Point4 a = corner - origin;
  const double vw01 = v[0] * w[1] - v[1] * w[0];
  const double vw02 = v[0] * w[2] - v[2] * w[0];
  const double vw03 = v[0] * w[3] - v[3] * w[0];
  const double vw12 = v[1] * w[2] - v[2] * w[1];
  const double vw13 = v[1] * w[3] - v[3] * w[1];
  const double vw23 = v[2] * w[3] - v[3] * w[2];
  Flux flux;
  flux.normal = {
      u[1] * vw23 - u[2] * vw13 + u[3] * vw12, -(u[0] * vw23 - u[2] * vw03 + u[3] * vw02),
      u[0] * vw13 - u[1] * vw03 + u[3] * vw01, -(u[0] * vw12 - u[1] * vw02 + u[2] * vw01)};
  // The centroid is a + (u + v + w) / 4.
  flux.value = 0;
  flux.magnitude = 0;
  const double longest = std::max({std::abs(u[0]) + std::abs(u[1]) + std::abs(u[2]),
                                   std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]),
                                   std::abs(w[0]) + std::abs(w[1]) + std::abs(w[2])});
  for (int k = 0; k < 3; ++k) {
    const double fourfold = 4 * a[k] + u[k] + v[k] + w[k];
    flux.value += flux.normal[k] * fourfold;
    flux.magnitude += std::abs(fourfold);
  }
  // Each product in the spatial components of the normal has one time and two lengths.
  flux.magnitude *= longest * longest * (std::abs(u[3]) + std::abs(v[3]) + std::abs(w[3]));
  return flux;
}

/// Adds the same value without rounding: with f the sum of the four corners, it is
/// det[(f_x, 0, 0, 0), u, v, w] and the same for y and z.
void addExactFlux(const model::Slab& slab, const model::Cell& cell, const model::Point4& origin,
                  model::ExactSum& sum) {
  using Factor = model::ExactSum::Factor;
  const auto corner = [&](int i) -> const model::Point4& { return slab.vertices[cell[i]]; };
  std::array<std::array<Factor, 4>, 3> edges;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) {
      edges[i][k] = Factor::difference(corner(i + 1)[k], corner(0)[k]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::array<std::array<Factor, 4>, 4> rows;
    for (int i = 0; i < 4; ++i) {
      rows[0][axis].add(Factor::difference(corner(i)[axis], origin[axis]));
    }
    std::ranges::copy(edges, rows.begin() + 1);
    addDeterminant(sum, rows);
  }
}

/// Adds up what `add` puts in for each cell, on all threads.
template <class Add>
model::ExactSum sumOver(std::span<const model::Cell> cells, Add add) {
  return model::reduce<model::ExactSum>(
      cells.size(), 1024,
      [&](std::size_t begin, std::size_t end, model::ExactSum sum) {
        for (std::size_t i = begin; i < end; ++i) add(cells[i], sum);
        return sum;
      },
      [](model::ExactSum a, const model::ExactSum& b) {
        a.add(b);
        return a;
      });
}

/// Powers of two by which each axis of a slab is scaled where products would leave the range of
/// doubles.
class UnitAxes {
 public:
  explicit UnitAxes(const model::Slab& slab) {
    model::Bounds4 bounds;
    for (const model::Point4& vertex : slab.vertices) bounds.add(vertex);
    const model::Point4 size = bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs());
    for (int axis = 0; axis < 4; ++axis) scales_[axis] = model::UnitScale(size[axis]);
    change_ = std::ranges::any_of(scales_, [](const auto& scale) { return scale.changes(); });
  }

  bool change() const { return change_; }
  model::Point4 toUnit(model::Point4 point) const {
    for (int axis = 0; axis < 4; ++axis) point[axis] = scales_[axis].toUnit(point[axis]);
    return point;
  }
  model::Slab toUnit(const model::Slab& slab) const {
    model::Slab scaled;
    scaled.timeBegin = scales_[3].toUnit(slab.timeBegin);
    scaled.timeEnd = scales_[3].toUnit(slab.timeEnd);
    scaled.connectivity = slab.connectivity;
    scaled.vertices.reserve(slab.vertices.size());
    for (const model::Point4& vertex : slab.vertices) scaled.vertices.push_back(toUnit(vertex));
    return scaled;
  }
  double hypervolumeFromUnit(double value) const { return std::ldexp(value, exponentWithout(4)); }
  /// The length of a cell's normal.
  double lengthFromUnit(const std::array<double, 4>& normal) const {
    model::Point4 changed(normal.data());
    if (change_) {
      for (int axis = 0; axis < 4; ++axis) {
        changed[axis] = std::ldexp(normal[axis], exponentWithout(axis));
      }
    }
    // Dividing by the largest component first takes longer than all else that a cell needs.
    const double squared = changed.squaredNorm();
    constexpr double kLeast = 1e-280;
    constexpr double kMost = 1e300;
    return squared > kLeast && squared < kMost ? std::sqrt(squared) : changed.stableNorm();
  }

 private:
  /// The exponent of the product of the units of all axes but one, to the base two.
  int exponentWithout(int axis) const {
    int sum = 0;
    for (int other = 0; other < 4; ++other) {
      if (other != axis && scales_[other].changes()) sum += std::ilogb(scales_[other].fromUnit(1));
    }
    return sum;
  }

  std::array<model::UnitScale, 4> scales_;
  bool change_ = false;
};

/// Cells that are measured together: sums of fixed pieces do not depend on the number of threads.
constexpr std::size_t kSummedCells = 16384;

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

SlabMeasure measureOf(const model::Slab& given, const model::Point4& givenRounding) {
  SlabMeasure measured;
  if (given.vertices.empty()) return measured;
  const UnitAxes axes(given);
  const model::Slab inUnit = axes.change() ? axes.toUnit(given) : model::Slab();
  const model::Slab& slab = axes.change() ? inUnit : given;
  const model::Point4 rounding = axes.toUnit(givenRounding);
  const model::Point4& origin = slab.vertices.front();
  const std::vector<model::Cell>& cells = slab.connectivity->cells;
  struct Piece {
    double flux72 = 0;
    double magnitude = 0;
    double measure6 = 0;
    std::vector<std::uint32_t> flat;
  };
  std::vector<Piece> pieces((cells.size() + kSummedCells - 1) / kSummedCells);
  model::forEach(pieces.size(), [&](std::size_t number) {
    Piece& piece = pieces[number];
    const std::size_t end = std::min(cells.size(), (number + 1) * kSummedCells);
    for (std::size_t i = number * kSummedCells; i < end; ++i) {
      const auto flux = fluxThrough(slab, cells[i], origin);
      piece.flux72 += flux.value;
      piece.magnitude += flux.magnitude;
      piece.measure6 += axes.lengthFromUnit(flux.normal);
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
  measured.boundaryVolume = measure6 / 6;
  if (slab.timeBegin == slab.timeEnd) {
    flux72 = 0;
  } else if (!model::isPrecise(flux72, magnitude)) {
    model::ExactSum sum = sumOver(cells, [&](const model::Cell& cell, model::ExactSum& into) {
      addExactFlux(slab, cell, origin, into);
    });
    measured.sign = sum.sign();
    measured.hypervolume = axes.hypervolumeFromUnit(sum.dividedBy(72));
    return measured;
  }
  measured.sign = (flux72 > 0) - (flux72 < 0);
  measured.hypervolume = axes.hypervolumeFromUnit(flux72 / 72);
  return measured;
}

int hypervolumeSign(std::span<const model::Point4> vertices, std::span<const model::Cell> cells) {
  if (cells.empty()) return 0;
  const model::Point4& origin = vertices.front();
  struct Piece {
    double sum = 0;
    double magnitude = 0;
  };
  std::vector<Piece> pieces((cells.size() + kSummedCells - 1) / kSummedCells);
  model::forEach(pieces.size(), [&](std::size_t number) {
    Piece& piece = pieces[number];
    const std::size_t end = std::min(cells.size(), (number + 1) * kSummedCells);
    for (std::size_t i = number * kSummedCells; i < end; ++i) {
      // Expanded by minors of x and y and of z and t (Laplace).
      std::array<model::Point4, 4> p;
      for (int k = 0; k < 4; ++k) p[k] = vertices[cells[i][k]] - origin;
      constexpr std::array<std::array<int, 4>, 6> kRows = {
          {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};
      for (const auto& [a, b, c, d] : kRows) {
        const double left = p[a][0] * p[b][1];
        const double right = p[a][1] * p[b][0];
        const double first = p[c][2] * p[d][3];
        const double second = p[c][3] * p[d][2];
        piece.sum += (left - right) * (first - second);
        piece.magnitude +=
            (std::abs(left) + std::abs(right)) * (std::abs(first) + std::abs(second));
      }
    }
  });
  double sum = 0;
  double magnitude = 0;
  for (const Piece& piece : pieces) {
    sum += piece.sum;
    magnitude += piece.magnitude;
  }
  // There are at most 2^32 cells, so each partial sum is one of fewer than 2^20 numbers.
  constexpr double kRounding = 0x1p21 * std::numeric_limits<double>::epsilon();
  if (std::isfinite(magnitude) && std::abs(sum) > kRounding * magnitude + model::kVanished) {
    return sum > 0 ? 1 : -1;
  }
  return sumOver(cells,
                 [&](const model::Cell& cell, model::ExactSum& into) {
                   std::array<std::array<model::ExactSum::Factor, 4>, 4> rows;
                   for (int i = 0; i < 4; ++i) {
                     for (int k = 0; k < 4; ++k) {
                       rows[i][k] =
                           model::ExactSum::Factor::difference(vertices[cell[i]][k], origin[k]);
                     }
                   }
                   addDeterminant(into, rows);
                 })
      .sign();
}

}  // namespace t4d::measure
