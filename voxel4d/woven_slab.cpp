#include "voxel4d/woven_slab.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>

#include "model/parallel.h"
#include "voxel4d/block_ranges.h"

namespace t4d::voxel4d {
namespace {

using model::Cell;
using model::Point4;

/// The maximum number of blocks within tiles that are inside in one frame and not in the other.
/// Each has 512 points that cross the surface and takes some 100 kB in the mesh, while a tile of
/// billions of points takes a few bytes in a file. So their number must be in proportion to what is
/// stored.
std::size_t mostAppearingBlocks(const FrameLayer& frame) {
  constexpr std::size_t kBlocks = std::size_t{1} << 14;
  constexpr std::size_t kBlocksPerStored = 64;
  return kBlocks + kBlocksPerStored * frame.storedBlocks();
}

/// The numbers of the crossings that the cubes of a block can need, of each kind of edge from each
/// of 9 x 9 x 9 points: those of the block and the next along each axis. Only those of edges that
/// are crossed are set.
class CrossingNumbers {
 public:
  static constexpr unsigned kStrideX = 81;
  static constexpr unsigned kStrideY = 9;

  /// The kinds of edges: along x, y, z at the first time, the same at the second, and along t.
  static constexpr unsigned kKinds = 7;
  static constexpr unsigned kInTime = 6;

  /// Takes the crossings in one of the 8 blocks (neighbour d), numbered from `first` on.
  void add(unsigned d, unsigned kind, const BlockMask& crossed, std::uint32_t first) {
    const std::uint64_t wanted =
        ((d & 2U) != 0 ? 0xFFU : kAllBits) & ((d & 4U) != 0 ? 0x0101010101010101U : kAllBits);
    std::uint32_t* const numbers = numbers_.data() + kind * kPoints +
                                   ((d & 1U) != 0 ? 8 * kStrideX : 0) +
                                   ((d & 2U) != 0 ? 8 * kStrideY : 0) + ((d & 4U) != 0 ? 8 : 0);
    const unsigned words = (d & 1U) != 0 ? 1 : 8;
    for (unsigned x = 0; x < words; ++x) {
      for (std::uint64_t left = crossed[x] & wanted; left != 0; left &= left - 1) {
        const auto bit = static_cast<unsigned>(std::countr_zero(left));
        numbers[x * kStrideX + (bit >> 3U) * kStrideY + (bit & 7U)] =
            first + countBefore(crossed[x], bit);
      }
      first += static_cast<std::uint32_t>(std::popcount(crossed[x]));
    }
  }

  /// The numbers of the edges of the cube at this point of the block: that of edge e is at
  /// kOffsets[e].
  const std::uint32_t* at(unsigned index) const {
    return numbers_.data() + (index >> 6U) * kStrideX + (index >> 3U & 7U) * kStrideY +
           (index & 7U);
  }
  static const std::array<unsigned, kEdges> kOffsets;

 private:
  static constexpr unsigned kPoints = 729;
  std::array<std::uint32_t, std::size_t{kKinds} * kPoints> numbers_;
};

const std::array<unsigned, kEdges> CrossingNumbers::kOffsets = [] {
  std::array<unsigned, kEdges> offsets{};
  for (int edge = 0; edge < kEdges; ++edge) {
    const auto axis = static_cast<unsigned>(edgeAxis(edge));
    const auto corner = static_cast<unsigned>(edgeCorner(edge));
    const unsigned kind = axis == 3 ? kInTime : axis + (corner >> 3U) * 3;
    offsets[edge] = kind * kPoints + (corner & 1U) * kStrideX + (corner >> 1U & 1U) * kStrideY +
                    (corner >> 2U & 1U);
  }
  return offsets;
}();

/// Blocks that are entirely inside in one frame and not in the other.
Result<void> addAppearing(const FrameLayer& frame, const FrameLayer& other,
                          std::vector<Coord>& coords) {
  const auto add = [&](const Coord& coord) {
    const BlockView view = other.view(coord);
    if (view.block != nullptr || !view.inside) coords.push_back(coord);
  };
  for (const Coord& coord : frame.solidBlocks()) add(coord);
  const std::size_t most = mostAppearingBlocks(frame);
  const std::size_t begin = coords.size();
  for (const InsideTile& tile : frame.tiles()) {
    if (other.coversInside(tile)) continue;
    for (std::int32_t x = 0; x < tile.size; ++x) {
      for (std::int32_t y = 0; y < tile.size; ++y) {
        for (std::int32_t z = 0; z < tile.size; ++z) {
          add({tile.coord.x + x, tile.coord.y + y, tile.coord.z + z});
          if (coords.size() - begin > most) {
            return invalid(
                fmt::format("more than {} points within tiles appear or vanish between "
                            "two frames, where only {} blocks are stored; give frames "
                            "closer in time",
                            512 * most, frame.storedBlocks()));
          }
        }
      }
    }
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<WovenSlab>> WovenSlab::between(
    const FrameLayer& before, const FrameLayer& after, const model::TimeSpan& time,
    const model::TimeSpan& crossings, const Lattice& lattice, const FaceMetric* metric) {
  std::unique_ptr<WovenSlab> slab(new WovenSlab(before, after, crossings, lattice, metric));
  slab->time = time;
  if (auto found = slab->findBlocks(); !found) return found.error();
  model::forEach(slab->blocks_.size(), [&](std::size_t i) { slab->findCubes(slab->blocks_[i]); });
  if (auto numbered = slab->number(); !numbered) return numbered.error();
  if (slab->metric_ != nullptr) slab->findFractions();
  return slab;
}

void WovenSlab::vertices(std::uint32_t first, std::span<Point4> into) const {
  // Takes what is left of `into` up to number `end` of the slab.
  const auto until = [&](std::uint32_t end) {
    const auto part = into.first(std::min<std::size_t>(into.size(), end - std::min(first, end)));
    into = into.subspan(part.size());
    return part;
  };
  const auto lower = until(lowerCount);
  before_.vertices(first, lower);
  first += static_cast<std::uint32_t>(lower.size());
  const auto interior = until(firstUpper());
  makeRange(
      first, interior, blocks_.size(),
      [&](std::size_t i) { return i < blocks_.size() ? blocks_[i].firstTime : firstUpper(); },
      [&](std::size_t i, Point4* at) { placeInTime(blocks_[i], at); });
  first += static_cast<std::uint32_t>(interior.size());
  const std::uint32_t firstOfUpper = first - std::min(first, firstUpper());
  after_.vertices(firstOfUpper, into);
}

void WovenSlab::cells(std::uint64_t first, std::span<Cell> into) const {
  makeRange(
      first, into, blocks_.size(),
      [&](std::size_t i) {
        return i < blocks_.size() ? std::uint64_t{blocks_[i].firstCell} : cellCount;
      },
      [&](std::size_t i, Cell* at) { emitCells(blocks_[i], at); });
}

/// Passes the index of each point of a block whose sign differs between the frames, in order.
template <class Take>
void WovenSlab::eachInTime(const WovenBlock& block, Take take) const {
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t bits = block.timeEdges[x]; bits != 0; bits &= bits - 1) {
      take(x << 6U | static_cast<unsigned>(std::countr_zero(bits)));
    }
  }
}

/// Computes when the points of a block are crossed, as fractions of the time between the frames.
void WovenSlab::fractionsByDistance(const WovenBlock& block, float* into) const {
  FaceDistance a(before_, *metric_, block.coord);
  FaceDistance b(after_, *metric_, block.coord);
  eachInTime(block, [&](unsigned index) {
    *into++ = static_cast<float>(crossing(a.at(index), b.at(index)));
  });
}

/// Computes the fractions of all blocks, in parallel: no other step takes as long.
void WovenSlab::findFractions() {
  fractions_.resize(firstUpper() - lowerCount);
  model::forEach(blocks_.size(), [&](std::size_t i) {
    fractionsByDistance(blocks_[i], fractions_.data() + (blocks_[i].firstTime - lowerCount));
  });
}

/// The crossings along t that begin in a block.
void WovenSlab::placeInTime(const WovenBlock& block, Point4* into) const {
  if (countOf(block.timeEdges) == 0) return;
  const bool values = metric_ == nullptr && before_.hasValues() && after_.hasValues();
  std::array<ValueBuffer, 2> buffers;
  const BlockField a = values ? before_.field(block.coord, buffers[0]) : BlockField();
  const BlockField b = values ? after_.field(block.coord, buffers[1]) : BlockField();
  const double duration = crossings_.end - crossings_.begin;
  const bool rounded = metric_ != nullptr || (before_.hasFloats() && after_.hasFloats());
  const CrossingGrid grid(rounded ? duration : 0);
  const float* known = fractions_.empty() ? nullptr : &fractions_[block.firstTime - lowerCount];
  eachInTime(block, [&](unsigned index) {
    const double fraction = known != nullptr ? static_cast<double>(*known++)
                            : values         ? crossing(a.at(index), b.at(index))
                                             : 0.5;
    const auto place = [&](int axis, std::int32_t ofBlock, unsigned local) {
      return lattice_.along(axis, kBlockSize * static_cast<double>(ofBlock) + local);
    };
    *into++ << place(0, block.coord.x, index >> 6U), place(1, block.coord.y, index >> 3U & 7U),
        place(2, block.coord.z, index & 7U), grid.nearest(crossings_.begin + fraction * duration);
  });
}

/// Finds the blocks in which a mixed hypercube can begin: those at the surface of one of the
/// frames, and those that are inside in one frame and outside in the other.
Result<void> WovenSlab::findBlocks() {
  std::vector<Coord> coords = before_.surfaceBlocks();
  coords.insert(coords.end(), after_.surfaceBlocks().begin(), after_.surfaceBlocks().end());
  if (auto added = addAppearing(before_, after_, coords); !added) return added;
  if (auto added = addAppearing(after_, before_, coords); !added) return added;
  model::sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
  const WeavingOrder order(coords.size());
  if (!order.isPlain()) model::sort(coords.begin(), coords.end(), order);
  blocks_.resize(coords.size());
  index_.reserve(coords.size());
  for (std::uint32_t i = 0; i < coords.size(); ++i) {
    blocks_[i].coord = coords[i];
    index_.add(coords[i], i);
  }
  return {};
}

void WovenSlab::findCubes(WovenBlock& block) const {
  std::array<BlockMask, kCorners> corners;
  for (unsigned time = 0; time < 2; ++time) {
    const FrameLayer& frame = time == 0 ? before_ : after_;
    std::array<BlockView, 8> views;
    for (unsigned d = 0; d < 8; ++d) views[d] = frame.view(neighbour(block.coord, d));
    for (unsigned d = 0; d < 8; ++d) corners[time << 3U | d] = shiftedSigns(views, d);
  }
  BlockMask mixed;
  std::size_t count = 0;
  for (unsigned x = 0; x < 8; ++x) {
    block.timeEdges[x] = corners[0][x] ^ corners[8][x];
    std::uint64_t all = kAllBits;
    std::uint64_t any = 0;
    for (const BlockMask& corner : corners) {
      all &= corner[x];
      any |= corner[x];
    }
    mixed[x] = any & ~all;
    count += static_cast<std::size_t>(std::popcount(mixed[x]));
  }
  block.cubes.reserve(count);
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t left = mixed[x]; left != 0; left &= left - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(left));
      unsigned pattern = 0;
      for (unsigned corner = 0; corner < kCorners; ++corner) {
        pattern |= static_cast<unsigned>(corners[corner][x] >> bit & 1U) << corner;
      }
      block.cubes.emplace_back(static_cast<std::uint16_t>(x << 6U | bit),
                               static_cast<std::uint16_t>(pattern));
    }
  }
}

/// Numbers the interior vertices and the cells.
Result<void> WovenSlab::number() {
  lowerCount = before_.vertexCount();
  upperCount = after_.vertexCount();
  std::uint64_t vertices = lowerCount;
  for (WovenBlock& block : blocks_) {
    block.firstTime = static_cast<std::uint32_t>(vertices);
    vertices += countOf(block.timeEdges);
    block.firstCell = static_cast<std::uint32_t>(cellCount);
    for (const auto& [index, pattern] : block.cubes) cellCount += PatternTable::count(pattern);
  }
  vertices += upperCount;
  if (std::max(vertices, cellCount) > std::numeric_limits<std::uint32_t>::max()) {
    return invalid(
        fmt::format("a slab between two frames would have {} vertices and {} cells; at "
                    "most 4294967295 are possible",
                    vertices, cellCount));
  }
  vertexCount = static_cast<std::uint32_t>(vertices);
  return {};
}

void WovenSlab::emitCells(const WovenBlock& block, Cell* into) const {
  if (block.cubes.empty()) return;
  CrossingNumbers numbers;
  for (unsigned d = 0; d < 8; ++d) {
    const Coord at = neighbour(block.coord, d);
    for (unsigned time = 0; time < 2; ++time) {
      const CrossingBlock* crossings = (time == 0 ? before_ : after_).crossings(at);
      if (crossings == nullptr) continue;
      std::uint32_t first = crossings->first + (time == 0 ? 0 : firstUpper());
      for (unsigned axis = 0; axis < 3; ++axis) {
        const BlockMask& crossed = crossings->edges[axis];
        numbers.add(d, 3 * time + axis, crossed, first);
        first += countOf(crossed);
      }
    }
    if (const auto found = index_.find(at)) {
      const WovenBlock& between = blocks_[*found];
      numbers.add(d, CrossingNumbers::kInTime, between.timeEdges, between.firstTime);
    }
  }
  for (const auto& [index, pattern] : block.cubes) {
    const std::uint32_t* const ofCube = numbers.at(index);
    const auto vertex = [&](std::uint8_t edge) { return ofCube[CrossingNumbers::kOffsets[edge]]; };
    for (const auto& [a, b, c, d] : PatternTable::tetrahedra(pattern)) {
      *into++ = {vertex(a), vertex(b), vertex(c), vertex(d)};
    }
  }
}

}  // namespace t4d::voxel4d
