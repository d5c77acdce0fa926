#include "voxel4d/occupancy.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "model/distance.h"
#include "model/parallel.h"
#include "model/surface_check.h"
#include "model/voxel_size.h"
#include "voxel4d/fixed_point.h"
#include "voxel4d/union_surface.h"

namespace t4d::voxel4d {

using model::Point3;
using model::squaredDistanceToSegment;
using model::Triangle;
using model::TriangleMesh;

namespace {

/// A surface on a lattice: its vertices in voxels.
struct Scene {
  Scene(std::vector<Point3> vertices, std::span<const Triangle> all)
      : points(std::move(vertices)), triangles(all), scale(points, all) {
    fixed.reserve(points.size());
    for (const Point3& point : points) fixed.push_back(scale.fixed(point));
    onSurface = kOnSurface * scale.largest();
    unit = scale.unit();
  }

  std::vector<Point3> points;
  std::span<const Triangle> triangles;
  FixedScale scale;
  std::vector<FixedPoint> fixed;
  std::int64_t unit;  // one voxel in fixed coordinates
  double onSurface;   // in voxels
};

std::vector<Point3> pointsOnLattice(const TriangleMesh& mesh, const Lattice& lattice) {
  std::vector<Point3> points;
  points.reserve(mesh.vertices.size());
  for (const Point3& vertex : mesh.vertices) {
    points.emplace_back((vertex - lattice.origin) / lattice.voxelSize);
  }
  return points;
}

/// On which side of the line from a to b a column lies: positive on the left. For the other
/// triangle of this edge it is exactly the negative.
struct Side {
  Side(const Scene& scene, const FixedPoint& a, const FixedPoint& b, std::int64_t x, std::int64_t y)
      : stepX(-static_cast<Int128>(b[1] - a[1]) * scene.unit),
        stepY(static_cast<Int128>(b[0] - a[0]) * scene.unit),
        atRow(static_cast<Int128>(b[0] - a[0]) * (y * scene.unit - a[1]) -
              static_cast<Int128>(b[1] - a[1]) * (x * scene.unit - a[0])),
        at(atRow),
        shifted(stepX != 0 ? stepX > 0 : stepY > 0) {}

  bool left() const { return at != 0 ? at > 0 : shifted; }
  void nextX() { at += stepX; }
  void nextY() {
    atRow += stepY;
    at = atRow;
  }

  Int128 stepX;
  Int128 stepY;
  Int128 atRow;
  Int128 at;
  bool shifted;  // the side of the column shifted by (e, e^2), if it lies on the line
};

struct Crossing {
  double z;
  std::int32_t winding;  // 1 where the solid begins, -1 where it ends
};

std::int64_t floorOf(double value) { return static_cast<std::int64_t>(std::floor(value)); }
std::int64_t ceilOf(double value) { return static_cast<std::int64_t>(std::ceil(value)); }

/// Calls `found(x, y, z, winding)` for each column with x in [xBegin, xEnd] that crosses the
/// triangle.
template <class Found>
void cross(const Scene& scene, const Triangle& triangle, std::int64_t xBegin, std::int64_t xEnd,
           const Found& found) {
  const FixedPoint& a = scene.fixed[triangle[0]];
  const FixedPoint& b = scene.fixed[triangle[1]];
  const FixedPoint& c = scene.fixed[triangle[2]];
  const Int128 area = static_cast<Int128>(b[0] - a[0]) * (c[1] - a[1]) -
                      static_cast<Int128>(b[1] - a[1]) * (c[0] - a[0]);
  if (area == 0) return;
  const auto down = [&](std::int64_t v) { return v >= 0 ? v / scene.unit : ~(~v / scene.unit); };
  const std::int64_t x0 = std::max(xBegin, down(std::min({a[0], b[0], c[0]})));
  const std::int64_t x1 = std::min(xEnd, down(std::max({a[0], b[0], c[0]})));
  const std::int64_t y0 = down(std::min({a[1], b[1], c[1]}));
  const std::int64_t y1 = down(std::max({a[1], b[1], c[1]}));
  const double za = scene.points[triangle[0]].z();
  const double zb = scene.points[triangle[1]].z();
  const double zc = scene.points[triangle[2]].z();
  const bool up = area > 0;
  const auto inverse = 1 / static_cast<double>(area);
  Side ab(scene, a, b, x0, y0);
  Side bc(scene, b, c, x0, y0);
  Side ca(scene, c, a, x0, y0);
  for (std::int64_t y = y0; y <= y1; ++y) {
    for (std::int64_t x = x0; x <= x1; ++x) {
      if (ab.left() == up && bc.left() == up && ca.left() == up) {
        // A weighted mean of the corners, so that rounding cannot move it off the triangle.
        const double wa = static_cast<double>(bc.at) * inverse;
        const double wb = static_cast<double>(ca.at) * inverse;
        const double wc = static_cast<double>(ab.at) * inverse;
        // Columns leave a solid at its top.
        found(x, y, wa * za + wb * zb + wc * zc, up ? -1 : 1);
      }
      ab.nextX();
      bc.nextX();
      ca.nextX();
    }
    ab.nextY();
    bc.nextY();
    ca.nextY();
  }
}

/// Calls `found(x, y, z)` for each lattice point on the triangle with x in [xBegin, xEnd]. Along
/// the axis nearest to the normal, only one point of each column can lie on it.
template <class Found>
void touch(std::span<const Point3> points, const Triangle& triangle, double tolerance,
           std::int64_t xBegin, std::int64_t xEnd, const Found& found) {
  const Point3& a = points[triangle[0]];
  const Point3& b = points[triangle[1]];
  const Point3& c = points[triangle[2]];
  const Point3 low = a.cwiseMin(b).cwiseMin(c);
  const Point3 high = a.cwiseMax(b).cwiseMax(c);
  Eigen::Matrix<std::int64_t, 3, 1> first;
  Eigen::Matrix<std::int64_t, 3, 1> last;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = ceilOf(low[axis] - tolerance);
    last[axis] = floorOf(high[axis] + tolerance);
  }
  first[0] = std::max(first[0], xBegin);
  last[0] = std::min(last[0], xEnd);
  if ((first.array() > last.array()).any()) return;

  const Point3 normal = (b - a).cross(c - a);
  const double size = normal.norm();
  const auto isOn = [&](const Point3& p) {
    if (size > 0) {
      const bool within = normal.dot((b - a).cross(p - a)) >= 0 &&
                          normal.dot((c - b).cross(p - b)) >= 0 &&
                          normal.dot((a - c).cross(p - c)) >= 0;
      if (within) return std::abs(normal.dot(p - a)) <= tolerance * size;
    }
    return std::min({squaredDistanceToSegment(p, a, b), squaredDistanceToSegment(p, b, c),
                     squaredDistanceToSegment(p, c, a)}) <= tolerance * tolerance;
  };
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  Point3 p;
  for (std::int64_t i = first[u]; i <= last[u]; ++i) {
    p[u] = static_cast<double>(i);
    for (std::int64_t j = first[v]; j <= last[v]; ++j) {
      p[v] = static_cast<double>(j);
      double height = a[axis];
      if (size > 0) {
        height -= (normal[u] * (p[u] - a[u]) + normal[v] * (p[v] - a[v])) / normal[axis];
      }
      // The column may be beside the triangle, where the plane's height is unbounded.
      height = std::round(std::clamp(height, low[axis] - 1, high[axis] + 1));
      if (height < static_cast<double>(first[axis]) || height > static_cast<double>(last[axis])) {
        continue;
      }
      p[axis] = height;
      if (isOn(p)) {
        found(static_cast<std::int64_t>(p.x()), static_cast<std::int64_t>(p.y()),
              static_cast<std::int64_t>(p.z()));
      }
    }
  }
}

/// The blocks that a solid reaches: its bounding box, without a margin.
struct BlockBox {
  Coord min;
  Coord max;
};

std::int32_t blockOf(std::int64_t coordinate) { return static_cast<std::int32_t>(coordinate >> 3); }

BlockBox blockBoxOf(const Scene& scene) {
  model::Bounds3 bounds;
  for (const Triangle& triangle : scene.triangles) {
    for (const auto vertex : triangle) bounds.add(scene.points[vertex]);
  }
  const auto low = [&](int axis) { return blockOf(floorOf(bounds.min[axis])); };
  const auto high = [&](int axis) { return blockOf(ceilOf(bounds.max[axis])); };
  return {{low(0), low(1), low(2)}, {high(0), high(1), high(2)}};
}

/// Triangles in voxels, and those that reach each block coordinate x, in increasing order.
class Buckets {
 public:
  Buckets(std::span<const Point3> points, std::span<const Triangle> triangles, double onSurface,
          const BlockBox& box)
      : points_(points), triangles_(triangles), first_(slicesOf(box) + 1) {
    const auto rangeOf = [&](const Triangle& t) {
      const auto [low, high] = std::minmax({points[t[0]].x(), points[t[1]].x(), points[t[2]].x()});
      const auto clamped = [&](std::int64_t x) {
        return std::clamp(blockOf(x), box.min.x, box.max.x) - box.min.x;
      };
      // Columns that are on the surface up to rounding count as on it.
      return std::pair(clamped(floorOf(low - onSurface)), clamped(ceilOf(high)));
    };
    for (const Triangle& triangle : triangles) {
      const auto [low, high] = rangeOf(triangle);
      for (auto i = low; i <= high; ++i) ++first_[i + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    numbers_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t number = 0; number < triangles.size(); ++number) {
      const auto [low, high] = rangeOf(triangles[number]);
      for (auto i = low; i <= high; ++i) numbers_[next[i]++] = number;
    }
  }

  static std::size_t slicesOf(const BlockBox& box) {
    return static_cast<std::size_t>(box.max.x - box.min.x) + 1;
  }
  std::span<const Point3> points() const { return points_; }
  template <class Visit>
  void visit(std::size_t slice, const Visit& visit) const {
    for (std::size_t i = first_[slice]; i < first_[slice + 1]; ++i) visit(triangles_[numbers_[i]]);
  }

 private:
  std::span<const Point3> points_;
  std::span<const Triangle> triangles_;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> numbers_;
};

/// The surface of a solid: all of it, which columns cross, and its parts that lattice points may be
/// on.
struct Parts {
  const Buckets& all;
  const Buckets& outer;  ///< points on it are outside
  const Buckets& inner;  ///< points on it, but not on `outer`, are inside
};

/// All blocks with the same x. Lattice columns are numbered x + 8 y within it.
class BlockSlice {
 public:
  BlockSlice(const Scene& scene, const BlockBox& box, std::int32_t x, const Parts& parts)
      : scene_(scene),
        box_(box),
        x_(x),
        yFirst_(std::int64_t{kBlockSize} * box.min.y),
        columns_(std::size_t{kBlockSize} * kBlockSize * (box.max.y - box.min.y + 1)) {
    const auto slice = static_cast<std::size_t>(x - box.min.x);
    findCrossings(parts.all, slice);
    onOuter_ = touched(parts.outer, slice);
    onInner_ = touched(parts.inner, slice);
    std::vector<BlockMask> row(box.max.z - box.min.z + 1);
    for (std::int32_t y = box.min.y; y <= box.max.y; ++y) fillRow(y, row);
  }

  std::vector<Block> blocks;
  std::vector<InsideTile> tiles;
  /// Whether a column crosses the surface within the solid.
  bool overlaps = false;
  /// The points on the outer surface that their columns have inside.
  std::vector<Coord> removed;

 private:
  std::size_t columnOf(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((x & 7) + kBlockSize * (y - yFirst_));
  }

  void findCrossings(const Buckets& triangles, std::size_t slice) {
    const std::int64_t xBegin = std::int64_t{kBlockSize} * x_;
    struct Found {
      std::size_t column;
      Crossing crossing;
    };
    std::vector<Found> found;
    first_.assign(columns_ + 1, 0);
    triangles.visit(slice, [&](const Triangle& triangle) {
      cross(scene_, triangle, xBegin, xBegin + kBlockSize - 1,
            [&](std::int64_t x, std::int64_t y, double z, int winding) {
              const std::size_t column = columnOf(x, y);
              ++first_[column + 1];
              found.push_back({column, {z, winding}});
            });
    });
    for (std::size_t i = 0; i < columns_; ++i) first_[i + 1] += first_[i];
    crossings_.resize(found.size());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const Found& f : found) crossings_[next[f.column]++] = f.crossing;
    for (std::size_t i = 0; i < columns_; ++i) {
      std::sort(crossings_.begin() + static_cast<std::ptrdiff_t>(first_[i]),
                crossings_.begin() + static_cast<std::ptrdiff_t>(first_[i + 1]),
                [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
    }
  }

  /// The lattice points on triangles, by increasing y.
  std::vector<Coord> touched(const Buckets& triangles, std::size_t slice) const {
    const std::int64_t xBegin = std::int64_t{kBlockSize} * x_;
    std::vector<Coord> found;
    triangles.visit(slice, [&](const Triangle& triangle) {
      touch(triangles.points(), triangle, scene_.onSurface, xBegin, xBegin + kBlockSize - 1,
            [&](std::int64_t x, std::int64_t y, std::int64_t z) {
              found.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                               static_cast<std::int32_t>(z)});
            });
    });
    std::sort(found.begin(), found.end(), [](const Coord& a, const Coord& b) { return a.y < b.y; });
    return found;
  }

  /// Calls `set(point, word, bit)` for each of `points` in a row of blocks, of which those with
  /// smaller y have been visited.
  template <class Set>
  void visitRow(const std::vector<Coord>& points, std::size_t& next, std::int32_t y,
                std::vector<BlockMask>& row, const Set& set) const {
    for (; next < points.size() && blockOf(points[next].y) <= y; ++next) {
      const Coord& c = points[next];
      const std::int32_t block = blockOf(c.z) - box_.min.z;
      if (blockOf(c.y) < y || block < 0 || static_cast<std::size_t>(block) >= row.size()) continue;
      set(c, row[block][c.x & 7], std::uint64_t{1} << (8 * (c.y & 7) + (c.z & 7)));
    }
  }

  void fillRow(std::int32_t y, std::vector<BlockMask>& row) {
    std::fill(row.begin(), row.end(), BlockMask{});
    const std::int64_t yBegin = std::int64_t{kBlockSize} * y;
    for (std::int64_t yy = yBegin; yy < yBegin + kBlockSize; ++yy) {
      for (std::int64_t xx = 0; xx < kBlockSize; ++xx) fillColumn(xx, yy, row);
    }
    visitRow(onInner_, nextInner_, y, row,
             [](const Coord& /*point*/, std::uint64_t& word, std::uint64_t bit) { word |= bit; });
    visitRow(onOuter_, nextOuter_, y, row,
             [&](const Coord& point, std::uint64_t& word, std::uint64_t bit) {
               if ((word & bit) != 0) removed.push_back(point);
               word &= ~bit;
             });
    for (std::size_t i = 0; i < row.size(); ++i) {
      const Coord coord{x_, y, box_.min.z + static_cast<std::int32_t>(i)};
      std::uint64_t any = 0;
      std::uint64_t all = kAllBits;
      for (const std::uint64_t word : row[i]) {
        any |= word;
        all &= word;
      }
      if (all == kAllBits) {
        tiles.push_back({coord, 1, 0});
      } else if (any != 0) {
        blocks.push_back({coord, row[i], {}});
      }
    }
  }

  void fillColumn(std::int64_t x, std::int64_t y, std::vector<BlockMask>& row) {
    const std::size_t column = columnOf(x, y);
    const std::int64_t zMin = std::int64_t{kBlockSize} * box_.min.z;
    const std::int64_t zMax = std::int64_t{kBlockSize} * box_.max.z + kBlockSize - 1;
    const auto shift = static_cast<unsigned>(8 * (y & 7));
    int winding = 0;
    for (std::size_t i = first_[column]; i + 1 < first_[column + 1]; ++i) {
      const bool within = winding != 0;
      winding += crossings_[i].winding;
      if (winding == 0) {
        // The end of one solid may be the begin of the next.
        overlaps = overlaps || crossings_[i + 1].z - crossings_[i].z <= scene_.onSurface;
        continue;
      }
      overlaps = overlaps || within;
      const std::int64_t begin = std::max(zMin, floorOf(crossings_[i].z) + 1);
      const std::int64_t end = std::min(zMax + 1, ceilOf(crossings_[i + 1].z));
      for (std::int64_t z = begin; z < end;) {
        const std::int64_t stop = std::min(end, (z | 7) + 1);
        const std::uint64_t bits = (std::uint64_t{1} << (stop - z)) - 1;
        row[blockOf(z) - box_.min.z][x] |= bits << (z & 7) << shift;
        z = stop;
      }
    }
  }

  const Scene& scene_;
  const BlockBox& box_;
  std::int32_t x_;
  std::int64_t yFirst_;
  std::size_t columns_;
  std::vector<std::size_t> first_;  // index of the first crossing of column i
  std::vector<Crossing> crossings_;
  std::vector<Coord> onOuter_;
  std::size_t nextOuter_ = 0;
  std::vector<Coord> onInner_;
  std::size_t nextInner_ = 0;
};

/// Sets the blocks and tiles of a frame. Returns whether parts of the surface seem to lie within
/// the solid: a column crosses them, or a point on the surface is between two inside points.
bool fill(const Scene& scene, const BlockBox& box, const Parts& parts, Frame& frame) {
  struct Found {
    std::vector<Block> blocks;
    std::vector<InsideTile> tiles;
    std::vector<Coord> removed;
    bool overlaps = false;
  };
  std::vector<Found> slices(Buckets::slicesOf(box));
  model::forEach(slices.size(), [&](std::size_t i) {
    BlockSlice slice(scene, box, box.min.x + static_cast<std::int32_t>(i), parts);
    slices[i] = {std::move(slice.blocks), std::move(slice.tiles), std::move(slice.removed),
                 slice.overlaps};
  });
  frame.blocks.clear();
  frame.tiles.clear();
  for (const Found& slice : slices) {
    frame.blocks.insert(frame.blocks.end(), slice.blocks.begin(), slice.blocks.end());
    frame.tiles.insert(frame.tiles.end(), slice.tiles.begin(), slice.tiles.end());
  }
  const auto isInside = [&](const Coord& point) {
    const BlockMask mask = insideOf(frame, {blockOf(point.x), blockOf(point.y), blockOf(point.z)});
    return (mask[point.x & 7] >> (8 * (point.y & 7) + (point.z & 7)) & 1U) != 0;
  };
  const auto isBetween = [&](const Coord& p) {
    return (isInside({p.x - 1, p.y, p.z}) && isInside({p.x + 1, p.y, p.z})) ||
           (isInside({p.x, p.y - 1, p.z}) && isInside({p.x, p.y + 1, p.z})) ||
           (isInside({p.x, p.y, p.z - 1}) && isInside({p.x, p.y, p.z + 1}));
  };
  model::forEach(slices.size(), [&](std::size_t i) {
    Found& slice = slices[i];
    slice.overlaps = slice.overlaps || std::ranges::any_of(slice.removed, isBetween);
  });
  return std::ranges::any_of(slices, [](const Found& slice) { return slice.overlaps; });
}

}  // namespace

Result<void> checkVoxelizable(const TriangleMesh& mesh, const Lattice& lattice) {
  if (auto sized = model::checkVoxelSize(lattice.voxelSize); !sized) return sized;
  if (mesh.triangles.empty()) return {};
  const auto usable = [&](const Triangle& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t vertex) {
      return vertex < mesh.vertices.size() && mesh.vertices[vertex].allFinite();
    });
  };
  if (!std::all_of(mesh.triangles.begin(), mesh.triangles.end(), usable) || !isClosed(mesh)) {
    // checkClosedSurface says where. It may be stricter: here a vertex or an edge may join several
    // surfaces.
    if (auto closed = model::checkClosedSurface(mesh); !closed) return closed;
  }
  model::Bounds3 bounds;
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) bounds.add(mesh.vertices[vertex]);
  }
  const Point3 low = (bounds.min - lattice.origin) / lattice.voxelSize;
  const Point3 high = (bounds.max - lattice.origin) / lattice.voxelSize;
  const Point3 points = (high - low).array().ceil() + 1;
  if (!(points.prod() <= kMaxBoxPoints)) {
    return invalid(
        fmt::format("with a voxel size of {} the solid takes {:.0f} x {:.0f} x {:.0f} voxels "
                    "({:.3g}); at most {:.3g} are allowed: use larger voxels",
                    lattice.voxelSize, points.x(), points.y(), points.z(), points.prod(),
                    kMaxBoxPoints),
        {}, Remedy::VoxelSize);
  }
  const double furthest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (!(furthest < kMaxCoordinate)) {
    return invalid(
        fmt::format("with a voxel size of {} the solid is {:.3g} voxels from the lattice's origin; "
                    "at most {} are allowed: use larger voxels",
                    lattice.voxelSize, furthest, kMaxCoordinate),
        {}, Remedy::VoxelSize);
  }
  return {};
}

Result<Occupancy> occupancyOf(const TriangleMesh& mesh, const Lattice& lattice, double time) {
  if (auto checked = checkVoxelizable(mesh, lattice); !checked) return checked.error();
  Occupancy found;
  found.inside.time = time;
  if (mesh.triangles.empty()) return found;
  const Scene scene(pointsOnLattice(mesh, lattice), mesh.triangles);
  const BlockBox box = blockBoxOf(scene);
  const Buckets all(scene.points, scene.triangles, scene.onSurface, box);
  if (!hasOverlappingComponents(scene.points, scene.triangles, scene.onSurface)) {
    // What lies within a solid of one component is rare, and shows here where it matters.
    const Buckets none({}, {}, 0, box);
    if (!fill(scene, box, {all, all, none}, found.inside)) {
      found.surface = {scene.points, mesh.triangles, {}};
      return found;
    }
  }
  found.surface = unionSurface(scene.points, scene.triangles, scene.onSurface);
  const auto bucketsOf = [&](const std::vector<Triangle>& triangles) {
    return Buckets(found.surface.points, triangles, scene.onSurface, box);
  };
  fill(scene, box, {all, bucketsOf(found.surface.outer), bucketsOf(found.surface.inner)},
       found.inside);
  return found;
}

Result<Frame> occupancy(const TriangleMesh& mesh, const Lattice& lattice, double time) {
  auto found = occupancyOf(mesh, lattice, time);
  if (!found) return found.error();
  return std::move(found->inside);
}

BlockMask insideOf(const Frame& frame, const Coord& block) {
  const auto found = std::lower_bound(frame.blocks.begin(), frame.blocks.end(), block,
                                      [](const Block& b, const Coord& c) { return b.coord < c; });
  if (found != frame.blocks.end() && found->coord == block) return found->inside;
  BlockMask mask{};
  const auto tile =
      std::lower_bound(frame.tiles.begin(), frame.tiles.end(), block,
                       [](const InsideTile& t, const Coord& c) { return t.coord < c; });
  if (tile != frame.tiles.end() && tile->coord == block) mask.fill(kAllBits);
  return mask;
}

}  // namespace t4d::voxel4d
