#include "t4d/voxel4d/frame_layer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "t4d/voxel4d/block_ranges.h"

namespace t4d::voxel4d {
namespace {

/// The maximum number of faces of blocks at which a tile meets the outside: tiles of a few bytes in
/// a file may have millions. So their number must be in proportion to what is stored.
std::uint64_t mostBareFaces(std::size_t storedBlocks) {
  constexpr std::uint64_t kFaces = std::uint64_t{1} << 15;
  constexpr std::uint64_t kFacesPerStored = 64;
  return kFaces + kFacesPerStored * storedBlocks;
}

Coord scaledDown(const Coord& coord, std::int32_t size) {
  // Sizes are powers of two; an arithmetic shift rounds down for negative numbers too.
  const int shift = std::countr_zero(static_cast<std::uint32_t>(size));
  return {coord.x >> shift, coord.y >> shift, coord.z >> shift};
}

void sortUnique(std::vector<Coord>& coords) {
  tbb::parallel_sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
}

}  // namespace

BlockMask shiftedSigns(const std::array<BlockView, 8>& views, unsigned d) {
  constexpr std::uint64_t kLastZ = 0x8080808080808080U;  // bits with z = 7
  const unsigned dx = d & 1U;
  const bool dy = (d & 2U) != 0;
  const bool dz = (d & 4U) != 0;
  BlockMask signs;
  for (unsigned x = 0; x < 8; ++x) {
    const unsigned wx = (x + dx) & 7U;
    const unsigned nx = (x + dx) >> 3U;  // 1 past the block's end
    const auto word = [&](unsigned ny, unsigned nz) {
      return views[nx | ny << 1U | nz << 2U].word(wx);
    };
    const auto alongZ = [&](unsigned ny) {
      const std::uint64_t here = word(ny, 0);
      return dz ? (here >> 1U & ~kLastZ) | (word(ny, 1) << 7U & kLastZ) : here;
    };
    signs[x] = dy ? alongZ(0) >> 8U | alongZ(1) << 56U : alongZ(0);
  }
  return signs;
}

Result<std::uint32_t> numberFrom(std::uint32_t first, CrossingBlock& block) {
  std::uint64_t next = first;
  for (int axis = 0; axis < 3; ++axis) {
    for (unsigned x = 0; x < 8; ++x) {
      block.first[axis][x] = static_cast<std::uint32_t>(next);
      next += static_cast<unsigned>(std::popcount(block.edges[axis][x]));
    }
  }
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (next > kMost) {
    return invalid(
        fmt::format("the surface crosses more than {} edges of the lattice, the most that are "
                    "possible",
                    kMost));
  }
  return static_cast<std::uint32_t>(next);
}

Result<FrameLayer> FrameLayer::of(Frame frame, const Lattice& lattice) {
  FrameLayer layer;
  layer.frame_ = std::move(frame);
  layer.lattice_ = lattice;
  layer.index();
  if (auto found = layer.findSurfaceBlocks(); !found) return pass(found.error());
  if (auto numbered = layer.numberCrossings(); !numbered) return pass(numbered.error());
  return layer;
}

void FrameLayer::index() {
  blocks_.reserve(frame_.blocks.size());
  for (std::uint32_t i = 0; i < frame_.blocks.size(); ++i) {
    const Block& block = frame_.blocks[i];
    blocks_.add(block.coord, i);
    if (std::all_of(block.inside.begin(), block.inside.end(),
                    [](std::uint64_t word) { return word == kAllBits; })) {
      solidBlocks_.push_back(block.coord);
    }
  }
  std::map<std::int32_t, std::vector<std::uint32_t>> bySize;
  for (std::uint32_t i = 0; i < frame_.tiles.size(); ++i) bySize[frame_.tiles[i].size].push_back(i);
  for (const auto& [size, tiles] : bySize) {
    TileLevel& level = tileLevels_.emplace_back(TileLevel{size, {}});
    level.tiles.reserve(tiles.size());
    for (const std::uint32_t i : tiles) level.tiles.add(scaledDown(frame_.tiles[i].coord, size), i);
  }
}

const InsideTile* FrameLayer::tileAt(const Coord& coord) const {
  for (const TileLevel& level : tileLevels_) {
    if (const auto found = level.tiles.find(scaledDown(coord, level.size))) {
      return &frame_.tiles[*found];
    }
  }
  return nullptr;
}

bool FrameLayer::coversInside(const InsideTile& tile) const {
  const InsideTile* found = tileAt(tile.coord);
  return found != nullptr && found->size >= tile.size;
}

BlockView FrameLayer::view(const Coord& coord) const {
  if (const auto found = blocks_.find(coord)) {
    return {&frame_.blocks[*found], false, frame_.outsideValue};
  }
  if (const InsideTile* tile = tileAt(coord)) return {nullptr, true, tile->value};
  return {nullptr, false, frame_.outsideValue};
}

const CrossingBlock* FrameLayer::crossings(const Coord& coord) const {
  const auto found = crossingIndex_.find(coord);
  return found ? &crossings_[*found] : nullptr;
}

/// A cube with corners both inside and outside begins in a stored block or before one, or between
/// an inside tile and outside blocks that are not stored.
Result<void> FrameLayer::findSurfaceBlocks() {
  std::vector<Coord> candidates;
  const std::uint64_t most = mostBareFaces(storedBlocks());
  std::uint64_t bare = 0;  // faces of tiles next to which nothing is stored
  const auto addBefore = [&](const Coord& coord) {
    for (unsigned d = 0; d < 8; ++d) candidates.push_back(neighbour(coord, d, -1));
  };
  for (const Block& block : frame_.blocks) addBefore(block.coord);
  for (const InsideTile& tile : frame_.tiles) {
    // The blocks just outside each of the tile's six faces.
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int32_t side : {-1, tile.size}) {
        for (std::int32_t u = 0; u < tile.size; ++u) {
          for (std::int32_t v = 0; v < tile.size; ++v) {
            std::array<std::int32_t, 3> at = {tile.coord.x, tile.coord.y, tile.coord.z};
            at[axis] += side;
            at[(axis + 1) % 3] += u;
            at[(axis + 2) % 3] += v;
            const Coord outer{at[0], at[1], at[2]};
            if (isStored(outer) || tileAt(outer) != nullptr) continue;
            if (++bare > most) {
              return invalid(
                  fmt::format("more than {} points at the surface lie in tiles, where "
                              "only {} blocks are stored; store the surface in leaf "
                              "nodes, or use larger voxels",
                              64 * most, storedBlocks()));
            }
            addBefore(outer);
            at[axis] += side < 0 ? 1 : -1;
            addBefore({at[0], at[1], at[2]});
          }
        }
      }
    }
  }
  sortUnique(candidates);

  std::vector<std::uint8_t> mixed(candidates.size());
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    bool all = true;
    bool any = false;
    for (unsigned d = 0; d < 8; ++d) {
      const BlockView one = view(neighbour(candidates[i], d));
      for (unsigned x = 0; x < 8; ++x) {
        all = all && one.word(x) == kAllBits;
        any = any || one.word(x) != 0;
      }
    }
    mixed[i] = any && !all ? 1 : 0;
  });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (mixed[i] != 0) surfaceBlocks_.push_back(candidates[i]);
  }
  const WeavingOrder order(surfaceBlocks_.size());
  if (!order.isPlain()) tbb::parallel_sort(surfaceBlocks_.begin(), surfaceBlocks_.end(), order);
  return {};
}

Result<void> FrameLayer::numberCrossings() {
  // Edges begin in a block that also contains the start of a mixed cube.
  std::vector<CrossingBlock> all(surfaceBlocks_.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    std::array<BlockView, 8> views;
    for (unsigned d = 0; d < 8; ++d) views[d] = view(neighbour(surfaceBlocks_[i], d));
    all[i].coord = surfaceBlocks_[i];
    const BlockMask here = shiftedSigns(views, 0);
    for (int axis = 0; axis < 3; ++axis) {
      const BlockMask next = shiftedSigns(views, 1U << axis);
      for (unsigned x = 0; x < 8; ++x) all[i].edges[axis][x] = here[x] ^ next[x];
    }
  });
  crossingIndex_.reserve(all.size());
  std::uint32_t count = 0;
  for (CrossingBlock& block : all) {
    const auto next = numberFrom(count, block);
    if (!next) return pass(next.error());
    if (*next == count) continue;
    count = *next;
    crossingIndex_.add(block.coord, static_cast<std::uint32_t>(crossings_.size()));
    crossings_.push_back(block);
  }
  vertexCount_ = count;
  return {};
}

void FrameLayer::vertices(std::uint32_t first, std::span<model::Point4> into) const {
  const auto beginOf = [&](std::size_t i) {
    return i < crossings_.size() ? crossings_[i].first[0][0] : vertexCount_;
  };
  makeRange(first, into, crossings_.size(), beginOf,
            [&](std::size_t i, model::Point4* at) { placeCrossings(crossings_[i], at); });
}

void FrameLayer::placeCrossings(const CrossingBlock& block, model::Point4* into) const {
  const BlockView from = view(block.coord);
  into = placeAlong<0>(block, from, into);
  into = placeAlong<1>(block, from, into);
  placeAlong<2>(block, from, into);
}

/// The crossings of the edges along an axis; returns the end.
template <int Axis>
model::Point4* FrameLayer::placeAlong(const CrossingBlock& block, const BlockView& from,
                                      model::Point4* into) const {
  constexpr unsigned kStep = Axis == 0 ? 64 : Axis == 1 ? 8 : 1;  // to the next point
  const BlockView beyond = hasValues() ? view(neighbour(block.coord, 1U << Axis)) : BlockView();
  const bool round = hasValues() && !from.hasDoubles() && !beyond.hasDoubles();
  const CrossingGrid grid(round ? lattice_.voxelSize : 0);
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t bits = block.edges[Axis][x]; bits != 0; bits &= bits - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(bits));
      const unsigned index = x << 6U | bit;
      const std::array<unsigned, 3> local = {x, bit >> 3U, bit & 7U};
      double fraction = 0.5;
      if (hasValues()) {
        const bool leaves = local[Axis] == 7;
        const double next = leaves ? beyond.at(index - 7 * kStep) : from.at(index + kStep);
        fraction = crossing(from.at(index), next);
      }
      const auto place = [&](int axis, std::int32_t ofBlock) {
        const double point = kBlockSize * static_cast<double>(ofBlock) + local[axis];
        return axis == Axis ? grid.nearest(lattice_.along(axis, point + fraction))
                            : lattice_.along(axis, point);
      };
      *into++ << place(0, block.coord.x), place(1, block.coord.y), place(2, block.coord.z),
          frame_.time;
    }
  }
  return into;
}

}  // namespace t4d::voxel4d
