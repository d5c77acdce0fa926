#include "t4d/voxel4d/weave.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "t4d/voxel4d/frame_layer.h"
#include "t4d/voxel4d/pattern_table.h"

namespace t4d::voxel4d {
namespace {

using model::Cell;
using model::Point4;

/// The cubes that begin in one block, between two frames.
struct WovenBlock {
  Coord coord;
  BlockMask timeEdges{};                     // points whose sign differs between the frames
  std::array<std::uint32_t, 8> firstTime{};  // number of the first crossing in each word
  std::uint64_t firstCell = 0;
  std::uint32_t cellCount = 0;
  /// Cubes that have cells: the index of their lowest point in the block, and their pattern.
  std::vector<std::pair<std::uint16_t, std::uint16_t>> cubes;

  /// The number of the crossing along t at a point.
  std::uint32_t numberInTime(unsigned x, unsigned bit) const {
    return firstTime[x] + countBefore(timeEdges[x], bit);
  }
};

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

/// The slab between two frames.
class Weaver {
 public:
  Weaver(const FrameLayer& before, const FrameLayer& after) : before_(before), after_(after) {}

  Result<std::shared_ptr<const model::Connectivity>> connect() {
    if (auto found = findBlocks(); !found) return pass(found.error());
    const PatternTable& table = PatternTable::get();
    tbb::parallel_for(std::size_t{0}, blocks_.size(),
                      [&](std::size_t i) { findCubes(table, blocks_[i]); });
    auto connectivity = std::make_shared<model::Connectivity>();
    const std::uint64_t lower = before_.vertices().size();
    std::uint64_t vertices = lower;
    std::uint64_t cells = 0;
    for (WovenBlock& block : blocks_) {
      for (unsigned x = 0; x < 8; ++x) {
        block.firstTime[x] = static_cast<std::uint32_t>(vertices);
        vertices += static_cast<unsigned>(std::popcount(block.timeEdges[x]));
      }
      block.firstCell = cells;
      cells += block.cellCount;
    }
    interiorCount_ = static_cast<std::uint32_t>(vertices - lower);
    vertices += after_.vertices().size();
    if (std::max(vertices, cells) > std::numeric_limits<std::uint32_t>::max()) {
      return invalid(
          fmt::format("a slab between two frames would have {} vertices and {} cells; at "
                      "most 4294967295 are possible",
                      vertices, cells));
    }
    connectivity->vertexCount = static_cast<std::uint32_t>(vertices);
    connectivity->lowerCount = static_cast<std::uint32_t>(lower);
    connectivity->upperCount = static_cast<std::uint32_t>(after_.vertices().size());
    connectivity->cells.resize(cells);
    Cell* const into = connectivity->cells.data();
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t i) {
      emitCells(table, connectivity->firstUpper(), blocks_[i], into + blocks_[i].firstCell);
    });
    return connectivity;
  }

  /// All vertices of the slab; `timeAt(fraction)` is the time of a crossing along t.
  template <class TimeAt>
  std::vector<Point4> vertices(const Lattice& lattice, TimeAt timeAt) const {
    std::vector<Point4> all(before_.vertices().size() + interiorCount_ + after_.vertices().size());
    std::copy(before_.vertices().begin(), before_.vertices().end(), all.begin());
    std::copy(after_.vertices().begin(), after_.vertices().end(),
              all.end() - static_cast<std::ptrdiff_t>(after_.vertices().size()));
    const bool values = before_.hasValues() && after_.hasValues();
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t i) {
      const WovenBlock& block = blocks_[i];
      const BlockView a = before_.view(block.coord);
      const BlockView b = after_.view(block.coord);
      std::uint32_t number = block.firstTime[0];
      for (unsigned x = 0; x < 8; ++x) {
        for (std::uint64_t bits = block.timeEdges[x]; bits != 0; bits &= bits - 1) {
          const auto bit = static_cast<unsigned>(std::countr_zero(bits));
          const unsigned index = x << 6U | bit;
          const double fraction = values ? crossing(a.at(index), b.at(index)) : 0.5;
          const Eigen::Vector3d point(kBlockSize * static_cast<double>(block.coord.x) + x,
                                      kBlockSize * static_cast<double>(block.coord.y) + (bit >> 3U),
                                      kBlockSize * static_cast<double>(block.coord.z) + (bit & 7U));
          all[number++] << lattice(point), timeAt(fraction);
        }
      }
    });
    return all;
  }

 private:
  /// Finds the blocks in which a mixed hypercube can begin: those at the surface of one of the
  /// frames, and those that are inside in one frame and outside in the other.
  Result<void> findBlocks() {
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

  /// Blocks that are entirely inside in one frame and not in the other.
  static Result<void> addAppearing(const FrameLayer& frame, const FrameLayer& other,
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

  void findCubes(const PatternTable& table, WovenBlock& block) const {
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
        block.cellCount += table.count(pattern);
      }
    }
  }

  /// Numbers the edges of the cubes of one block: the tables of its 8 neighbours, at both times and
  /// between them.
  struct Neighbourhood {
    std::array<const CrossingBlock*, 8> before{};
    std::array<const CrossingBlock*, 8> after{};
    std::array<const WovenBlock*, 8> between{};
  };

  Neighbourhood neighbourhood(const Coord& coord) const {
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

  void emitCells(const PatternTable& table, std::uint32_t firstUpper, const WovenBlock& block,
                 Cell* into) const {
    if (block.cubes.empty()) return;
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
          vertex[edge] = firstUpper + around.after[d]->number(axis, px & 7U, bit);
        }
      }
      for (const auto& [a, b, c, d] : table.tetrahedra(pattern)) {
        *into++ = {vertex[a], vertex[b], vertex[c], vertex[d]};
      }
    }
  }

  const FrameLayer& before_;
  const FrameLayer& after_;
  std::vector<WovenBlock> blocks_;  // increasing by coord
  std::unordered_map<Coord, std::uint32_t, CoordHash> index_;
  std::uint32_t interiorCount_ = 0;
};

/// Puts the slabs of a mesh into the sink and counts them.
class SlabWriter {
 public:
  SlabWriter(const Lattice& lattice, model::Sink& sink) : lattice_(lattice), sink_(sink) {}

  template <class TimeAt>
  Result<void> put(const FrameLayer& before, const FrameLayer& after, double begin, double end,
                   TimeAt timeAt) {
    Weaver weaver(before, after);
    auto connectivity = weaver.connect();
    if (!connectivity) return pass(connectivity.error());
    model::Slab slab;
    slab.timeBegin = begin;
    slab.timeEnd = end;
    slab.connectivity = std::move(*connectivity);
    slab.vertices = weaver.vertices(lattice_, timeAt);
    report.vertices += slab.connectivity->vertexCount - slab.connectivity->lowerCount;
    lastTetrahedra = slab.connectivity->cells.size();
    report.tetrahedra += lastTetrahedra;
    return sink_.put(slab);
  }

  WeaveReport report;
  std::uint64_t lastTetrahedra = 0;  // of the last slab

 private:
  const Lattice& lattice_;
  model::Sink& sink_;
};

}  // namespace

Result<WeaveReport> weave(FrameSource& frames, const WeaveOptions& options, model::Sink& sink,
                          const model::Progress& progress) {
  const std::size_t count = frames.frameCount();
  if (count < 2) {
    return invalid(fmt::format("there are {} frames; a motion has at least two", count));
  }
  const Lattice lattice = frames.lattice();
  SlabWriter slabs(lattice, sink);
  const FrameLayer nothing;
  FrameLayer before;
  double halfStepAfter = 0;
  for (std::size_t i = 0; i < count; ++i) {
    auto frame = frames.frame(i);
    if (!frame) return pass(frame.error());
    if (auto checked = checkFrame(*frame); !checked) {
      return invalid(checked.error().message, fmt::format("frame {}", i));
    }
    auto layer = FrameLayer::of(std::move(*frame), lattice);
    if (!layer) {
      layer.error().where = fmt::format("frame {}", i);
      return pass(layer.error());
    }
    FrameLayer& after = *layer;
    const double begin = before.time();
    const double end = after.time();
    if (i > 0 && !(end > begin)) {
      return invalid(
          fmt::format("frame {} is at time {}, not after frame {}, at {}", i, end, i - 1, begin));
    }
    const bool half = options.caps == CapStyle::HalfStep;
    if (i == 1) {
      // The first cap waits for the second frame, which determines the length of a step.
      const double first = half ? model::dividedTime({end, begin}, 3, 2) : begin;
      if (auto put = slabs.put(nothing, before, first, begin, [&](double) { return first; });
          !put) {
        return pass(put.error());
      }
      slabs.report.capTetrahedra[0] = slabs.lastTetrahedra;
    }
    if (i > 0) {
      halfStepAfter = model::dividedTime({begin, end}, 3, 2);
      const auto timeAt = [&](double fraction) { return begin + fraction * (end - begin); };
      if (auto put = slabs.put(before, after, begin, end, timeAt); !put) return pass(put.error());
    }
    before = std::move(after);
    ++slabs.report.frames;
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(count));
  }
  const double end = before.time();
  const double last = options.caps == CapStyle::HalfStep ? halfStepAfter : end;
  if (auto put = slabs.put(before, nothing, end, last, [&](double) { return last; }); !put) {
    return pass(put.error());
  }
  slabs.report.capTetrahedra[1] = slabs.lastTetrahedra;
  if (slabs.report.tetrahedra == 0) {
    return invalid("no frame has a surface: nothing is inside at any time");
  }
  return slabs.report;
}

}  // namespace t4d::voxel4d
