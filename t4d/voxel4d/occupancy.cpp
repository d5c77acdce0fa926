#include "t4d/voxel4d/occupancy.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "t4d/model/distance.h"
#include "t4d/model/surface_check.h"
#include "t4d/model/voxel_size.h"

namespace t4d::voxel4d {

using model::Point3;
using model::squaredDistanceToSegment;
using model::Triangle;
using model::TriangleMesh;

namespace {

__extension__ typedef __int128 Int128;  // NOLINT(modernize-use-using)

/// Integer coordinates of a column's triangles, in units of a power of two of a voxel: below 2^60,
/// so that the cross product of two differences fits in 128 bits.
constexpr int kFixedBits = 60;

struct FixedPoint {
  std::int64_t x;
  std::int64_t y;
};

/// The solid's vertices in voxels.
struct Scene {
  std::vector<Point3> points;
  std::vector<FixedPoint> fixed;
  std::int64_t unit = 1;  // one voxel in fixed coordinates
  double onSurface = 0;   // in voxels
  std::span<const Triangle> triangles;
};

Scene sceneOf(const TriangleMesh& mesh, const Lattice& lattice) {
  Scene scene;
  scene.triangles = mesh.triangles;
  scene.points.reserve(mesh.vertices.size());
  double largest = 1;
  for (const Point3& vertex : mesh.vertices) {
    scene.points.emplace_back((vertex - lattice.origin) / lattice.voxelSize);
    largest = std::max(largest, scene.points.back().cwiseAbs().maxCoeff());
  }
  scene.onSurface = kOnSurface * largest;
  const int shift = kFixedBits - 1 - std::ilogb(largest);
  scene.unit = std::int64_t{1} << shift;
  scene.fixed.reserve(scene.points.size());
  for (const Point3& p : scene.points) {
    scene.fixed.push_back(
        {std::llround(std::ldexp(p.x(), shift)), std::llround(std::ldexp(p.y(), shift))});
  }
  return scene;
}

/// On which side of the line from a to b a column lies: positive on the left. For the other
/// triangle of this edge it is exactly the negative.
struct Side {
  Side(const Scene& scene, const FixedPoint& a, const FixedPoint& b, std::int64_t x, std::int64_t y)
      : stepX(-static_cast<Int128>(b.y - a.y) * scene.unit),
        stepY(static_cast<Int128>(b.x - a.x) * scene.unit),
        atRow(static_cast<Int128>(b.x - a.x) * (y * scene.unit - a.y) -
              static_cast<Int128>(b.y - a.y) * (x * scene.unit - a.x)),
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
  const Int128 area =
      static_cast<Int128>(b.x - a.x) * (c.y - a.y) - static_cast<Int128>(b.y - a.y) * (c.x - a.x);
  if (area == 0) return;
  const auto down = [&](std::int64_t v) { return v >= 0 ? v / scene.unit : ~(~v / scene.unit); };
  const std::int64_t x0 = std::max(xBegin, down(std::min({a.x, b.x, c.x})));
  const std::int64_t x1 = std::min(xEnd, down(std::max({a.x, b.x, c.x})));
  const std::int64_t y0 = down(std::min({a.y, b.y, c.y}));
  const std::int64_t y1 = down(std::max({a.y, b.y, c.y}));
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
        // At the top of a solid, columns leave it.
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
void touch(const Scene& scene, const Triangle& triangle, std::int64_t xBegin, std::int64_t xEnd,
           const Found& found) {
  const Point3& a = scene.points[triangle[0]];
  const Point3& b = scene.points[triangle[1]];
  const Point3& c = scene.points[triangle[2]];
  const double tolerance = scene.onSurface;
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

/// All blocks with the same x. Lattice columns are numbered x + 8 y within it.
class BlockSlice {
 public:
  BlockSlice(const Scene& scene, const BlockBox& box, std::int32_t x,
             std::span<const std::uint32_t> triangles)
      : scene_(scene),
        box_(box),
        x_(x),
        yFirst_(std::int64_t{kBlockSize} * box.min.y),
        columns_(std::size_t{kBlockSize} * kBlockSize * (box.max.y - box.min.y + 1)) {
    findCrossings(triangles);
    findTouched(triangles);
    std::vector<BlockMask> row(box.max.z - box.min.z + 1);
    for (std::int32_t y = box.min.y; y <= box.max.y; ++y) fillRow(y, row);
  }

  std::vector<Block> blocks;
  std::vector<InsideTile> tiles;

 private:
  std::size_t columnOf(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((x & 7) + kBlockSize * (y - yFirst_));
  }

  void findCrossings(std::span<const std::uint32_t> triangles) {
    const std::int64_t xBegin = std::int64_t{kBlockSize} * x_;
    struct Found {
      std::size_t column;
      Crossing crossing;
    };
    std::vector<Found> found;
    first_.assign(columns_ + 1, 0);
    for (const std::uint32_t index : triangles) {
      cross(scene_, scene_.triangles[index], xBegin, xBegin + kBlockSize - 1,
            [&](std::int64_t x, std::int64_t y, double z, int winding) {
              const std::size_t column = columnOf(x, y);
              ++first_[column + 1];
              found.push_back({column, {z, winding}});
            });
    }
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

  void findTouched(std::span<const std::uint32_t> triangles) {
    const std::int64_t xBegin = std::int64_t{kBlockSize} * x_;
    for (const std::uint32_t index : triangles) {
      touch(scene_, scene_.triangles[index], xBegin, xBegin + kBlockSize - 1,
            [&](std::int64_t x, std::int64_t y, std::int64_t z) {
              touched_.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                  static_cast<std::int32_t>(z)});
            });
    }
    std::sort(touched_.begin(), touched_.end(),
              [](const Coord& a, const Coord& b) { return a.y < b.y; });
  }

  void fillRow(std::int32_t y, std::vector<BlockMask>& row) {
    std::fill(row.begin(), row.end(), BlockMask{});
    const std::int64_t yBegin = std::int64_t{kBlockSize} * y;
    for (std::int64_t yy = yBegin; yy < yBegin + kBlockSize; ++yy) {
      for (std::int64_t xx = 0; xx < kBlockSize; ++xx) fillColumn(xx, yy, row);
    }
    while (nextTouched_ < touched_.size() && touched_[nextTouched_].y < yBegin + kBlockSize) {
      const Coord& c = touched_[nextTouched_++];
      const std::int32_t block = blockOf(c.z) - box_.min.z;
      if (block < 0 || static_cast<std::size_t>(block) >= row.size()) continue;
      row[block][c.x & 7] &= ~(std::uint64_t{1} << (8 * (c.y & 7) + (c.z & 7)));
    }
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

  void fillColumn(std::int64_t x, std::int64_t y, std::vector<BlockMask>& row) const {
    const std::size_t column = columnOf(x, y);
    const std::int64_t zMin = std::int64_t{kBlockSize} * box_.min.z;
    const std::int64_t zMax = std::int64_t{kBlockSize} * box_.max.z + kBlockSize - 1;
    const auto shift = static_cast<unsigned>(8 * (y & 7));
    int winding = 0;
    for (std::size_t i = first_[column]; i + 1 < first_[column + 1]; ++i) {
      winding += crossings_[i].winding;
      if (winding == 0) continue;
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
  std::vector<Coord> touched_;  // by increasing y
  std::size_t nextTouched_ = 0;
};

/// For each block coordinate x, the triangles that reach it, in increasing order.
struct Buckets {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> triangles;
};

Buckets bucketsOf(const Scene& scene, const BlockBox& box) {
  const auto rangeOf = [&](const Triangle& t) {
    const auto [low, high] =
        std::minmax({scene.points[t[0]].x(), scene.points[t[1]].x(), scene.points[t[2]].x()});
    const auto clamped = [&](std::int64_t x) {
      return std::clamp(blockOf(x), box.min.x, box.max.x) - box.min.x;
    };
    // Columns that are on the surface up to rounding count as on it.
    return std::pair(clamped(floorOf(low - scene.onSurface)), clamped(ceilOf(high)));
  };
  Buckets buckets;
  buckets.first.assign(static_cast<std::size_t>(box.max.x - box.min.x) + 2, 0);
  for (const Triangle& triangle : scene.triangles) {
    const auto [low, high] = rangeOf(triangle);
    for (auto i = low; i <= high; ++i) ++buckets.first[i + 1];
  }
  for (std::size_t i = 1; i < buckets.first.size(); ++i) buckets.first[i] += buckets.first[i - 1];
  buckets.triangles.resize(buckets.first.back());
  std::vector<std::size_t> next(buckets.first.begin(), buckets.first.end() - 1);
  for (std::uint32_t index = 0; index < scene.triangles.size(); ++index) {
    const auto [low, high] = rangeOf(scene.triangles[index]);
    for (auto i = low; i <= high; ++i) buckets.triangles[next[i]++] = index;
  }
  return buckets;
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

Result<Frame> occupancy(const TriangleMesh& mesh, const Lattice& lattice, double time) {
  if (auto checked = checkVoxelizable(mesh, lattice); !checked) return checked.error();
  Frame frame;
  frame.time = time;
  if (mesh.triangles.empty()) return frame;
  const Scene scene = sceneOf(mesh, lattice);
  const BlockBox box = blockBoxOf(scene);
  const Buckets buckets = bucketsOf(scene, box);

  struct Found {
    std::vector<Block> blocks;
    std::vector<InsideTile> tiles;
  };
  std::vector<Found> slices(buckets.first.size() - 1);
  tbb::parallel_for(std::size_t{0}, slices.size(), [&](std::size_t i) {
    BlockSlice slice(scene, box, box.min.x + static_cast<std::int32_t>(i),
                     std::span(buckets.triangles)
                         .subspan(buckets.first[i], buckets.first[i + 1] - buckets.first[i]));
    slices[i] = {std::move(slice.blocks), std::move(slice.tiles)};
  });
  for (const Found& slice : slices) {
    frame.blocks.insert(frame.blocks.end(), slice.blocks.begin(), slice.blocks.end());
    frame.tiles.insert(frame.tiles.end(), slice.tiles.begin(), slice.tiles.end());
  }
  return frame;
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
