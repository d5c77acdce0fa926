#include "measure/visit_fields.h"

#include <algorithm>
#include <array>
#include <optional>

#include "measure/exact_signs.h"
#include "model/parallel.h"

namespace t4d::measure {
namespace {

using model::Point3;

// Cells that are looked at together.
constexpr std::size_t kSomeCells = 8192;

/// A cell over a point of the lattice.
struct Cover {
  std::size_t row;
  double time;
  int sign;  // 1 for an exit, -1 for an entry
};

/// A cell projected along t.
class ProjectedCell {
 public:
  ProjectedCell(const model::Slab& slab, const model::Cell& cell) {
    for (int k = 0; k < 4; ++k) {
      const model::Point4& corner = slab.vertices[cell[k]];
      corners_[k] = corner.head<3>();
      times_[k] = corner[3];
    }
  }

  Point3 least() const {
    return corners_[0].cwiseMin(corners_[1]).cwiseMin(corners_[2]).cwiseMin(corners_[3]);
  }
  Point3 most() const {
    return corners_[0].cwiseMax(corners_[1]).cwiseMax(corners_[2]).cwiseMax(corners_[3]);
  }

  /// The sign of the determinant in space; 0 if the cell covers nothing.
  int orient() {
    sign_ = orientation(corners_[0], corners_[1], corners_[2], corners_[3]);
    return sign_;
  }

  /// Whether the tetrahedron covers the point, moved by symbolic amounts.
  bool covers(const Point3& p) const {
    const auto& [a, b, c, d] = corners_;
    return movedOrientation(a, b, c, p) == sign_ && movedOrientation(a, b, d, p) == -sign_ &&
           movedOrientation(a, c, d, p) == sign_ && movedOrientation(b, c, d, p) == -sign_;
  }

  /// The time of the cell at a place.
  double timeAt(const Point3& p) const {
    double sum = 0;
    double weights = 0;
    for (int k = 0; k < 4; ++k) {
      const Point3& a = corners_[(k + 1) % 4];
      const double weight =
          (corners_[(k + 2) % 4] - a).cross(corners_[(k + 3) % 4] - a).dot(p - a) *
          (k % 2 == 0 ? 1 : -1);
      sum += weight * (times_[k] - times_[0]);
      weights += weight;
    }
    const auto [least, most] = std::ranges::minmax(times_);
    const double time = times_[0] + sum / weights;
    return time >= least && time <= most ? time : time > most ? most : least;
  }

 private:
  std::array<Point3, 4> corners_;
  std::array<double, 4> times_;
  int sign_ = 0;
};

}  // namespace

VisitFieldBuilder::VisitFieldBuilder(SpaceLattice lattice) {
  fields_.lattice = std::move(lattice);
  const std::size_t count = fields_.lattice.pointCount();
  fields_.visits.resize(count);
  fields_.dwell.resize(count);
  fields_.first.resize(count, std::numeric_limits<double>::infinity());
  fields_.last.resize(count, -std::numeric_limits<double>::infinity());
}

Result<void> VisitFieldBuilder::put(const model::Slab& slab) {
  if (auto sound = model::checkSlab(slab); !sound) return sound;
  const std::vector<model::Cell>& cells = slab.connectivity->cells;
  const SpaceLattice& lattice = fields_.lattice;
  std::vector<std::vector<Cover>> found((cells.size() + kSomeCells - 1) / kSomeCells);
  model::forEach(found.size(), [&](std::size_t group) {
    const std::size_t end = std::min((group + 1) * kSomeCells, cells.size());
    for (std::size_t i = group * kSomeCells; i < end; ++i) {
      ProjectedCell cell(slab, cells[i]);
      const Point3 least = cell.least();
      const Point3 most = cell.most();
      std::array<std::uint32_t, 3> from;
      std::array<std::uint32_t, 3> to;
      bool none = false;
      for (int axis = 0; axis < 3 && !none; ++axis) {
        from[axis] = lattice.firstFrom(axis, least[axis]);
        to[axis] = lattice.firstAfter(axis, most[axis]);
        none = from[axis] == to[axis];
      }
      if (none) continue;
      const int sign = -cell.orient();
      if (sign == 0) continue;
      LatticeIndex at;
      for (at[0] = from[0]; at[0] < to[0]; ++at[0]) {
        for (at[1] = from[1]; at[1] < to[1]; ++at[1]) {
          for (at[2] = from[2]; at[2] < to[2]; ++at[2]) {
            const Point3 point(lattice.at[0][at[0]], lattice.at[1][at[1]], lattice.at[2][at[2]]);
            if (cell.covers(point)) {
              found[group].push_back({fields_.rowOf(at), cell.timeAt(point), sign});
            }
          }
        }
      }
    }
  });
  // The cells of a cap may overlap (cones): what counts is whether the solid is there.
  if (slab.timeBegin == slab.timeEnd) {
    std::vector<Cover> all;
    for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
    std::ranges::sort(all, {}, &Cover::row);
    std::vector<Cover> net;
    for (const Cover& cover : all) {
      if (net.empty() || net.back().row != cover.row) {
        net.push_back(cover);
      } else {
        net.back().sign += cover.sign;
      }
    }
    found = {std::move(net)};
  }
  for (const auto& some : found) {
    for (const auto& [row, time, sign] : some) {
      fields_.dwell[row] += sign * time;
      if (sign > 0) {
        fields_.visits[row] += sign;
        fields_.last[row] = std::max(fields_.last[row], time);
      } else if (sign < 0) {
        fields_.first[row] = std::min(fields_.first[row], time);
      }
    }
  }
  return {};
}

VisitFields VisitFieldBuilder::finish() {
  for (std::size_t row = 0; row < fields_.visits.size(); ++row) {
    if (fields_.visits[row] > 0) continue;
    fields_.dwell[row] = fields_.first[row] = fields_.last[row] = 0;
  }
  return std::move(fields_);
}

}  // namespace t4d::measure
