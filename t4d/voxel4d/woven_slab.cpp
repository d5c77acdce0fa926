#include "t4d/voxel4d/woven_slab.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "t4d/voxel4d/block_ranges.h"

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

/// Axis and first corner of each edge.
struct EdgePlace {
  std::uint8_t axis;
  std::uint8_t corner;
};
constexpr std::array<EdgePlace, kEdges> kEdgePlaces = [] {
  std::array<EdgePlace, kEdges> places{};
  for (int edge = 0; edge < kEdges; ++edge) {
    places[edge] = {static_cast<std::uint8_t>(edgeAxis(edge)),
                    static_cast<std::uint8_t>(edgeCorner(edge))};
  }
  return places;
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

Result<std::unique_ptr<WovenSlab>> WovenSlab::between(const FrameLayer& before,
                                                      const FrameLayer& after,
                                                      const model::TimeSpan& time,
                                                      const model::TimeSpan& crossings,
                                                      const Lattice& lattice) {
  std::unique_ptr<WovenSlab> slab(new WovenSlab(before, after, crossings, lattice));
  slab->time = time;
  if (auto found = slab->findBlocks(); !found) return pass(found.error());
  tbb::parallel_for(std::size_t{0}, slab->blocks_.size(),
                    [&](std::size_t i) { slab->findCubes(slab->blocks_[i]); });
  if (auto numbered = slab->number(); !numbered) return pass(numbered.error());
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
      [&](std::size_t i) { return i < blocks_.size() ? blocks_[i].firstTime[0] : firstUpper(); },
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

/// The crossings along t that begin in a block.
void WovenSlab::placeInTime(const WovenBlock& block, Point4* into) const {
  const bool values = before_.hasValues() && after_.hasValues();
  const BlockView a = before_.view(block.coord);
  const BlockView b = after_.view(block.coord);
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t bits = block.timeEdges[x]; bits != 0; bits &= bits - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(bits));
      const unsigned index = x << 6U | bit;
      const double fraction = values ? crossing(a.at(index), b.at(index)) : 0.5;
      const Eigen::Vector3d point(kBlockSize * static_cast<double>(block.coord.x) + x,
                                  kBlockSize * static_cast<double>(block.coord.y) + (bit >> 3U),
                                  kBlockSize * static_cast<double>(block.coord.z) + (bit & 7U));
      *into++ << lattice_(point), crossings_.begin + fraction * (crossings_.end - crossings_.begin);
    }
  }
}

/// Finds the blocks in which a mixed hypercube can begin: those at the surface of one of the
/// frames, and those that are inside in one frame and outside in the other.
Result<void> WovenSlab::findBlocks() {
  std::vector<Coord> coords;
  std::set_union(before_.surfaceBlocks().begin(), before_.surfaceBlocks().end(),
                 after_.surfaceBlocks().begin(), after_.surfaceBlocks().end(),
                 std::back_inserter(coords));
  const std::size_t sorted = coords.size();
  if (auto added = addAppearing(before_, after_, coords); !added) return added;
  if (auto added = addAppearing(after_, before_, coords); !added) return added;
  if (coords.size() > sorted) {
    std::sort(coords.begin(), coords.end());
    coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
  }
  blocks_.resize(coords.size());
  index_.reserve(coords.size());
  for (std::uint32_t i = 0; i < coords.size(); ++i) {
    blocks_[i].coord = coords[i];
    index_[coords[i]] = i;
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
  for (unsigned x = 0; x < 8; ++x) {
    block.timeEdges[x] = corners[0][x] ^ corners[8][x];
    std::uint64_t all = kAllBits;
    std::uint64_t any = 0;
    for (const BlockMask& corner : corners) {
      all &= corner[x];
      any |= corner[x];
    }
    for (std::uint64_t mixed = any & ~all; mixed != 0; mixed &= mixed - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(mixed));
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
  const PatternTable& table = PatternTable::get();
  lowerCount = before_.vertexCount();
  upperCount = after_.vertexCount();
  std::uint64_t vertices = lowerCount;
  for (WovenBlock& block : blocks_) {
    for (unsigned x = 0; x < 8; ++x) {
      block.firstTime[x] = static_cast<std::uint32_t>(vertices);
      vertices += static_cast<unsigned>(std::popcount(block.timeEdges[x]));
    }
    block.firstCell = static_cast<std::uint32_t>(cellCount);
    for (const auto& [index, pattern] : block.cubes) cellCount += table.count(pattern);
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

WovenSlab::Neighbourhood WovenSlab::neighbourhood(const Coord& coord) const {
  Neighbourhood around;
  for (unsigned d = 0; d < 8; ++d) {
    const Coord at = neighbour(coord, d);
    around.before[d] = before_.crossings(at);
    around.after[d] = after_.crossings(at);
    const auto found = index_.find(at);
    around.between[d] = found == index_.end() ? nullptr : &blocks_[found->second];
  }
  return around;
}

void WovenSlab::emitCells(const WovenBlock& block, Cell* into) const {
  if (block.cubes.empty()) return;
  const PatternTable& table = PatternTable::get();
  const Neighbourhood around = neighbourhood(block.coord);
  std::array<std::uint32_t, kEdges> vertex{};
  for (const auto& [index, pattern] : block.cubes) {
    const unsigned x = index >> 6U;
    const unsigned y = index >> 3U & 7U;
    const unsigned z = index & 7U;
    for (std::uint32_t edges = table.edges(pattern); edges != 0; edges &= edges - 1) {
      const int edge = std::countr_zero(edges);
      const auto [axis, corner] = kEdgePlaces[edge];
      const unsigned px = x + (corner & 1U);
      const unsigned py = y + (corner >> 1U & 1U);
      const unsigned pz = z + (corner >> 2U & 1U);
      const unsigned d = px >> 3U | (py >> 3U) << 1U | (pz >> 3U) << 2U;
      const unsigned bit = (py & 7U) << 3U | (pz & 7U);
      if (axis == 3) {
        vertex[edge] = around.between[d]->numberInTime(px & 7U, bit);
      } else if ((corner & 8U) == 0) {
        vertex[edge] = around.before[d]->number(axis, px & 7U, bit);
      } else {
        vertex[edge] = firstUpper() + around.after[d]->number(axis, px & 7U, bit);
      }
    }
    for (const auto& [a, b, c, d] : table.tetrahedra(pattern)) {
      *into++ = {vertex[a], vertex[b], vertex[c], vertex[d]};
    }
  }
}

}  // namespace t4d::voxel4d
