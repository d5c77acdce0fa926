#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <unordered_set>

#include <Eigen/LU>
#include <fmt/format.h>

#include "model/limits.h"
#include "model/parallel.h"
#include "t4d/frames.h"
#include "voxel4d/occupancy.h"

namespace t4d::voxel4d {
namespace {

/// Lattice points have 32-bit coordinates, and a block has 8 of them along an axis.
constexpr std::int64_t kMostBlocks = std::int64_t{1} << 28;

std::string named(const char* what, const Coord& coord) {
  return fmt::format("the {} at ({}, {}, {})", what, coord.x, coord.y, coord.z);
}

bool isWithinLattice(const Coord& coord, std::int64_t size) {
  const auto within = [&](std::int64_t c) { return c >= -kMostBlocks && c + size <= kMostBlocks; };
  return within(coord.x) && within(coord.y) && within(coord.z);
}

/// The tiles seen so far, by size.
class TileIndex {
 public:
  void add(const InsideTile& tile) { bySize_[tile.size].insert(tile.coord); }

  /// Whether a tile of at least `least` blocks along each axis covers the block.
  bool covers(const Coord& block, std::int32_t least) const {
    for (auto level = bySize_.lower_bound(least); level != bySize_.end(); ++level) {
      const std::int32_t mask = ~(level->first - 1);
      if (level->second.contains({block.x & mask, block.y & mask, block.z & mask})) return true;
    }
    return false;
  }

 private:
  std::map<std::int32_t, std::unordered_set<Coord, CoordHash>> bySize_;
};

Result<void> checkTiles(const Frame& frame, TileIndex& index) {
  for (std::size_t i = 0; i < frame.tiles.size(); ++i) {
    const InsideTile& tile = frame.tiles[i];
    const auto wrong = [&](const std::string& message) {
      return invalid(fmt::format("{} {}", named("tile", tile.coord), message));
    };
    if (tile.size < 1 || !std::has_single_bit(static_cast<std::uint32_t>(tile.size))) {
      return wrong(fmt::format("has the size {}, which is not a power of two", tile.size));
    }
    if (((tile.coord.x | tile.coord.y | tile.coord.z) & (tile.size - 1)) != 0) {
      return wrong(fmt::format("is not at a multiple of its size {}", tile.size));
    }
    if (!isWithinLattice(tile.coord, tile.size)) return wrong("lies beyond 32-bit coordinates");
    if (i > 0 && !(frame.tiles[i - 1].coord < tile.coord)) {
      return wrong("does not come after the one before it");
    }
    if (frame.hasValues() ? !(std::isfinite(tile.value) && tile.value < 0) : tile.value != 0) {
      return wrong(fmt::format("has the value {}; expected {}", tile.value,
                               frame.hasValues() ? "a negative number" : "0, as it has no values"));
    }
    index.add(tile);
  }
  for (const InsideTile& tile : frame.tiles) {
    if (index.covers(tile.coord, 2 * tile.size)) {
      return invalid(named("tile", tile.coord) + " lies within another");
    }
  }
  return {};
}

/// Whether the values are finite, and negative where the block says that it is inside. It has no
/// branches, because it runs over all values of all frames.
template <class Value>
bool agree(const Block& block, const Value* values) {
  double notFinite = 0;  // becomes not a number
  std::uint64_t different = 0;
  for (unsigned x = 0; x < 8; ++x) {
    std::uint64_t negative = 0;
    for (unsigned bit = 0; bit < 64; ++bit) {
      const double value =
          block.values.sign * (static_cast<double>(values[x << 6U | bit]) - block.values.iso);
      notFinite += value - value;
      negative |= std::uint64_t{value < 0} << bit;
    }
    different |= negative ^ block.inside[x];
  }
  return notFinite == 0 && different == 0;
}

/// What is wrong with the values of a block, at the first such point; empty if nothing is.
std::string faultOfValues(const Frame& frame, std::size_t number) {
  const Block& block = frame.blocks[number];
  ValueBuffer buffer;
  const BlockValues values = valuesOf(frame, number, buffer);
  if (values.empty()) return frame.hasValues() ? "has no values, other than its frame" : "";
  if (!frame.hasValues()) return "has values, other than its frame";
  if (values.floats != nullptr ? agree(block, values.floats) : agree(block, values.doubles)) {
    return "";
  }
  for (unsigned i = 0; i < 512; ++i) {
    const double value = values.at(i);
    const bool inside = (block.inside[i >> 6U] >> (i & 63U) & 1U) != 0;
    if (!std::isfinite(value) || inside != (value < 0)) {
      return fmt::format("has the value {} at its point {}, which it says is {}", value, i,
                         inside ? "inside" : "outside");
    }
  }
  return {};
}

}  // namespace

Result<void> checkFrame(const Frame& frame) {
  if (!std::isfinite(frame.time)) return invalid(fmt::format("its time is {}", frame.time));
  if (!(std::isfinite(frame.outsideValue) && frame.outsideValue >= 0)) {
    return invalid(
        fmt::format("its value outside is {}; expected a positive number, or 0 for no "
                    "values",
                    frame.outsideValue));
  }
  if (frame.samples) return {};  // made by frameOf
  TileIndex tiles;
  if (auto checked = checkTiles(frame, tiles); !checked) return checked;
  for (std::size_t i = 0; i < frame.blocks.size(); ++i) {
    const Coord& coord = frame.blocks[i].coord;
    if (!isWithinLattice(coord, 1)) {
      return invalid(named("block", coord) + " lies beyond 32-bit coordinates");
    }
    if (i > 0 && !(frame.blocks[i - 1].coord < coord)) {
      return invalid(named("block", coord) + " does not come after the one before it");
    }
    if (tiles.covers(coord, 1)) return invalid(named("block", coord) + " lies within a tile");
  }
  std::vector<std::string> faults(frame.blocks.size());
  model::forEach(frame.blocks.size(), [&](std::size_t i) { faults[i] = faultOfValues(frame, i); });
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (faults[i].empty()) continue;
    return invalid(fmt::format("{} {}", named("block", frame.blocks[i].coord), faults[i]));
  }
  return {};
}

Result<void> checkPlace(const Frame& frame, const model::Affine3x4& place) {
  const Eigen::Matrix3d axes = place.leftCols<3>();
  const Eigen::RowVector3d edges = axes.colwise().norm();
  if (!place.allFinite() || !(edges.minCoeff() >= model::kSmallestExtent) ||
      !(edges.maxCoeff() <= model::kLargestCoordinate)) {
    return invalid(fmt::format("its voxels are {:.4g} x {:.4g} x {:.4g}; {} to {} are possible",
                               edges[0], edges[1], edges[2], model::kSmallestExtent,
                               model::kLargestCoordinate));
  }
  model::Bounds3 box;  // of what is inside, in lattice points
  const auto add = [&](const Coord& coord, std::int32_t size) {
    const Eigen::Vector3d first = Eigen::Vector3d(coord.x, coord.y, coord.z) * kBlockSize;
    box.add(first);
    box.add(first + Eigen::Vector3d::Constant(size * kBlockSize));
  };
  for (const Block& block : frame.blocks) {
    if (std::ranges::any_of(block.inside, [](std::uint64_t word) { return word != 0; })) {
      add(block.coord, 1);
    }
  }
  for (const InsideTile& tile : frame.tiles) add(tile.coord, tile.size);
  if (!(box.min[0] <= box.max[0])) return {};
  Eigen::Array3d farthest = Eigen::Array3d::Zero();
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto side = [&](unsigned axis) {
      return (corner >> axis & 1U) != 0 ? box.max[axis] : box.min[axis];
    };
    const Eigen::Vector3d at = axes * Eigen::Vector3d(side(0), side(1), side(2)) + place.col(3);
    farthest = farthest.max(at.array().abs());
  }
  // A rounding of coordinates becomes one along the axes of the lattice.
  const double scale = edges.maxCoeff();
  const Eigen::Matrix3d toVoxels = (axes / scale).inverse().cwiseAbs();
  const double voxels = (toVoxels * (farthest.matrix() / scale)).maxCoeff();
  if (voxels <= kMaxCoordinate && farthest.maxCoeff() <= model::kLargestCoordinate) return {};
  return invalid(
      fmt::format("lies up to {:.4g} voxels from the origin of space, where doubles "
                  "are too coarse for its voxels; at most {} are possible: move it "
                  "closer, or use larger voxels",
                  voxels, kMaxCoordinate));
}

}  // namespace t4d::voxel4d
