#include "voxel4d/frame_layer.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "model/parallel.h"
#include "platform/freed_memory.h"
#include "voxel4d/block_ranges.h"

namespace t4d::voxel4d {
namespace {

/// The maximum number of faces of blocks at which a tile meets the outside: tiles of a few bytes in
/// a file may have millions. So their number must be in proportion to what is stored.
std::uint64_t mostBareFaces(std::size_t storedBlocks) {
  constexpr std::uint64_t kFaces = std::uint64_t{1} << 15;
  constexpr std::uint64_t kFacesPerStored = 64;
  return kFaces + kFacesPerStored * storedBlocks;
}

void sortUnique(std::vector<Coord>& coords) {
  model::sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
}

/// The crossings along an axis: passes the index of the point before each in the block to `take`.
template <class Take>
void eachCrossing(const BlockMask& along, Take take) {
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t bits = along[x]; bits != 0; bits &= bits - 1) {
      take(x << 6U | static_cast<unsigned>(std::countr_zero(bits)));
    }
  }
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
  block.first = first;
  const std::uint64_t next = std::uint64_t{first} + block.count();
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (next > kMost) {
    return invalid(
        fmt::format("the surface crosses more than {} edges of the lattice, the most that are "
                    "possible",
                    kMost));
  }
  return static_cast<std::uint32_t>(next);
}

Result<FrameLayer> FrameLayer::of(Frame frame, const Lattice& lattice, std::size_t largeFrame) {
  FrameLayer layer;
  layer.frame_ = IndexedFrame(std::move(frame));
  layer.lattice_ = lattice;
  layer.hasFloats_ = layer.frame_.samples ? layer.frame_.samples->hasFloats()
                                          : valueSizeOf(layer.frame_) == sizeof(float);
  layer.findSolidBlocks();
  if (auto found = layer.findSurfaceBlocks(); !found) return found.error();
  if (auto numbered = layer.numberCrossings(); !numbered) return numbered.error();
  if (auto kept = layer.keepFractions(largeFrame); !kept) return kept.error();
  return layer;
}

void FrameLayer::findSolidBlocks() {
  for (const Block& block : frame_.blocks) {
    if (std::all_of(block.inside.begin(), block.inside.end(),
                    [](std::uint64_t word) { return word == kAllBits; })) {
      solidBlocks_.push_back(block.coord);
    }
  }
}

bool FrameLayer::coversInside(const InsideTile& tile) const {
  const auto found = frame_.tileAt(tile.coord);
  return found && frame_.tiles[*found].size >= tile.size;
}

BlockView FrameLayer::view(const Coord& coord) const {
  if (const auto found = frame_.blockAt(coord)) return {&frame_.blocks[*found], false};
  return {nullptr, frame_.tileAt(coord).has_value()};
}

BlockField FrameLayer::field(const Coord& coord, ValueBuffer& buffer) const {
  if (frame_.samples) return {{}, 0, frame_.samples.get(), coord};
  if (const auto found = frame_.blockAt(coord)) {
    return {valuesOf(frame_, *found, buffer), frame_.outsideValue};
  }
  const auto tile = frame_.tileAt(coord);
  return {{}, tile ? frame_.tiles[*tile].value : frame_.outsideValue};
}

Result<void> FrameLayer::checkRead() const {
  if (fractionsInFile_) {
    if (auto read = fractionsInFile_->checkRead(); !read) return read;
  }
  return frame_.file ? frame_.file->checkRead() : Result<void>();
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
  candidates.reserve(8 * frame_.blocks.size());
  const auto addBefore = [&](const Coord& coord) {
    for (unsigned d = 0; d < 8; ++d) candidates.push_back(neighbour(coord, d, -1));
  };
  for (const Block& block : frame_.blocks) addBefore(block.coord);
  for (const InsideTile& tile : frame_.tiles) {
    // The blocks just outside each of the tile's six faces. A cube that begins in the tile and ends
    // outside is in a block before one of these.
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int32_t side : {-1, tile.size}) {
        for (std::int32_t u = 0; u < tile.size; ++u) {
          for (std::int32_t v = 0; v < tile.size; ++v) {
            std::array<std::int32_t, 3> at = {tile.coord.x, tile.coord.y, tile.coord.z};
            at[axis] += side;
            at[(axis + 1) % 3] += u;
            at[(axis + 2) % 3] += v;
            const Coord outer{at[0], at[1], at[2]};
            if (frame_.blockAt(outer) || frame_.tileAt(outer)) continue;
            if (++bare > most) {
              return invalid(
                  fmt::format("more than {} points at the surface lie in tiles, where "
                              "only {} blocks are stored; store the surface in leaf "
                              "nodes, or use larger voxels",
                              64 * most, storedBlocks()));
            }
            addBefore(outer);
          }
        }
      }
    }
  }
  sortUnique(candidates);

  std::vector<std::uint8_t> mixed(candidates.size());
  model::forEach(candidates.size(), [&](std::size_t i) {
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
  if (!order.isPlain()) model::sort(surfaceBlocks_.begin(), surfaceBlocks_.end(), order);
  return {};
}

/// The crossed edges that begin in a block.
CrossingBlock FrameLayer::crossingsIn(const Coord& coord) const {
  std::array<BlockView, 8> views;
  for (unsigned d = 0; d < 8; ++d) views[d] = view(neighbour(coord, d));
  CrossingBlock block;
  block.coord = coord;
  const BlockMask here = shiftedSigns(views, 0);
  for (int axis = 0; axis < 3; ++axis) {
    const BlockMask next = shiftedSigns(views, 1U << axis);
    for (unsigned x = 0; x < 8; ++x) block.edges[axis][x] = here[x] ^ next[x];
  }
  return block;
}

Result<void> FrameLayer::numberCrossings() {
  // Edges begin in a block that also contains the start of a mixed cube. In a third of those none
  // does; room for them would be a tenth of the memory of a large frame.
  std::vector<std::uint8_t> any(surfaceBlocks_.size());
  model::forEach(any.size(), [&](std::size_t i) {
    any[i] = crossingsIn(surfaceBlocks_[i]).count() > 0 ? 1 : 0;
  });
  std::vector<Coord> coords;
  coords.reserve(static_cast<std::size_t>(std::ranges::count(any, 1)));
  for (std::size_t i = 0; i < any.size(); ++i) {
    if (any[i] != 0) coords.push_back(surfaceBlocks_[i]);
  }
  crossings_.resize(coords.size());
  model::forEach(coords.size(), [&](std::size_t i) { crossings_[i] = crossingsIn(coords[i]); });
  crossingIndex_.reserve(crossings_.size());
  for (std::uint32_t i = 0; i < crossings_.size(); ++i) {
    const auto next = numberFrom(vertexCount_, crossings_[i]);
    if (!next) return next.error();
    vertexCount_ = *next;
    crossingIndex_.add(crossings_[i].coord, i);
  }
  return {};
}

/// Passes the values at both ends of the crossed edges of a block to `take`.
template <class Take>
void FrameLayer::eachCrossed(const CrossingBlock& block, Take take) const {
  std::array<ValueBuffer, 2> buffers;
  const BlockField from = field(block.coord, buffers[0]);
  for (unsigned axis = 0; axis < 3; ++axis) {
    const BlockField beyond = field(neighbour(block.coord, 1U << axis), buffers[1]);
    const unsigned shift = 6 - 3 * axis;  // of the axis in an index
    eachCrossing(block.edges[axis], [&](unsigned index) {
      const bool leaves = (index >> shift & 7U) == 7;
      const double next =
          leaves ? beyond.at(index & ~(7U << shift)) : from.at(index + (1U << shift));
      take(Values{from.at(index), next});
    });
  }
}

/// Finds where along their edges the crossings of a block are. Returns whether all of them are
/// between these values, in one order or the other.
bool FrameLayer::findFractions(const CrossingBlock& block, const Values& first,
                               double* into) const {
  bool same = true;
  eachCrossed(block, [&](const Values& values) {
    same = same && std::minmax(values[0], values[1]) == std::minmax(first[0], first[1]);
    *into++ = crossing(values[0], values[1]);
  });
  return same;
}

/// Each crossing is placed several times: as one of the upper layer of a slab, of the lower layer
/// of the next, and where a slab is made in parts. Moves them, and the values, to a file if the
/// frame is large.
Result<void> FrameLayer::keepFractions(std::size_t largeFrame) {
  if (!hasValues() || crossings_.empty()) return {};
  Values first{};
  eachCrossed(crossings_.front(), [&](const Values& values) { first = values; });
  std::atomic<bool> same = true;
  const auto find = [&](const CrossingBlock& block, double* into) {
    if (!findFractions(block, first, into)) same.store(false, std::memory_order_relaxed);
  };
  const std::size_t blockBytes = valueSizeOf(frame_) * std::tuple_size_v<ValueBuffer>;
  if (blockBytes == 0 || blockBytes * frame_.blocks.size() < largeFrame) {
    fractions_.resize(vertexCount_);
    model::forEach(crossings_.size(),
                   [&](std::size_t i) { find(crossings_[i], fractions_.data() + firstOf(i)); });
    hasTwoValues_ = same;
    return {};
  }
  auto file = FrameFile::create();
  if (!file) return file.error();
  constexpr std::size_t kMost = std::size_t{1} << 16U;
  std::vector<double> fractions;
  for (std::size_t begin = 0, end = 0; begin < crossings_.size(); begin = end) {
    const std::uint32_t firstInPart = firstOf(begin);
    while (end < crossings_.size() && firstOf(end) < std::uint64_t{firstInPart} + kMost) ++end;
    fractions.resize(firstOf(end) - firstInPart);
    model::forEach(end - begin, [&](std::size_t i) {
      find(crossings_[begin + i], fractions.data() + (firstOf(begin + i) - firstInPart));
    });
    if (auto added = (*file)->append(std::as_bytes(std::span(fractions))); !added) return added;
  }
  fractionsInFile_ = std::move(*file);
  hasTwoValues_ = same;
  if (!frame_.file) {
    if (auto moved = moveValuesToFile(frame_); !moved) return moved;
  }
  platform::giveBackFreedMemory();
  return {};
}

void FrameLayer::vertices(std::uint32_t first, std::span<model::Point4> into) const {
  if (into.empty()) return;
  // A large frame gives the fractions of all blocks that have some of these vertices.
  std::vector<double> read;
  std::span<const double> fractions = fractions_;
  std::uint32_t firstFraction = 0;
  if (fractionsInFile_) {
    firstFraction = first - std::min(first, kMostInBlock);
    const std::uint64_t last = std::uint64_t{first} + into.size() + kMostInBlock;
    read.resize(std::min<std::uint64_t>(last, vertexCount_) - firstFraction);
    fractionsInFile_->read(std::uint64_t{firstFraction} * sizeof(double),
                           std::as_writable_bytes(std::span(read)));
    fractions = read;
  }
  makeRange(
      first, into, crossings_.size(), [&](std::size_t i) { return firstOf(i); },
      [&](std::size_t i, model::Point4* at) {
        place(crossings_[i], fractions.empty() ? nullptr : &fractions[firstOf(i) - firstFraction],
              at);
      });
}

/// The crossings of a block; at the midpoints without fractions.
void FrameLayer::place(const CrossingBlock& block, const double* fractions,
                       model::Point4* into) const {
  const CrossingGrid grid(hasFloats() ? lattice_.voxelSize : 0);
  const std::array<std::int32_t, 3> corner = {block.coord.x, block.coord.y, block.coord.z};
  for (int axis = 0; axis < 3; ++axis) {
    eachCrossing(block.edges[axis], [&](unsigned index) {
      const std::array<unsigned, 3> local = {index >> 6U, index >> 3U & 7U, index & 7U};
      model::Point4& vertex = *into++;
      for (int i = 0; i < 3; ++i) {
        const double point = kBlockSize * static_cast<double>(corner[i]) + local[i];
        vertex[i] = lattice_.along(i, point);
        if (i != axis) continue;
        const double fraction = fractions != nullptr ? *fractions++ : 0.5;
        vertex[i] = grid.nearest(lattice_.along(i, point + fraction));
      }
      vertex[3] = frame_.time;
    });
  }
}

}  // namespace t4d::voxel4d
