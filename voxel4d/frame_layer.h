#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "t4d/frames.h"
#include "voxel4d/coord_index.h"
#include "voxel4d/frame_file.h"
#include "voxel4d/indexed_frame.h"
#include "voxel4d/sample_box.h"

namespace t4d::voxel4d {

/// The signs of one block of a frame, or one sign for all of its points.
struct BlockView {
  const Block* block = nullptr;
  bool inside = false;  ///< for all points, if `block` is null

  std::uint64_t word(unsigned x) const {
    return block != nullptr ? block->inside[x] : inside ? kAllBits : 0;
  }
};

/// The field in one block of a frame.
struct BlockField {
  BlockValues values;                    ///< may be empty
  double value = 0;                      ///< of all points then
  const SampleField* samples = nullptr;  ///< instead of both, at `coord`
  Coord coord = {};

  double at(unsigned index) const {
    if (samples != nullptr) return samples->at(coord, index);
    return values.empty() ? value : values.at(index);
  }
};

/// The number of set bits of a word below `bit`.
inline std::uint32_t countBefore(std::uint64_t word, unsigned bit) {
  return static_cast<std::uint32_t>(std::popcount(word & ((std::uint64_t{1} << bit) - 1)));
}

/// The order in which blocks are woven: where there are many, cubes of 4 x 4 x 4 blocks one after
/// another, so that cells that follow one another are close in all directions. Where there are few,
/// such cubes would only make slabs differ that are the same but for their place.
class WeavingOrder {
 public:
  explicit WeavingOrder(std::size_t blocks) : shift_(blocks > kFew ? 2 : 0) {}

  /// Whether the order is that of the coordinates themselves.
  bool isPlain() const { return shift_ == 0; }

  bool operator()(const Coord& a, const Coord& b) const {
    const auto cube = [&](const Coord& c) {
      return Coord{c.x >> shift_, c.y >> shift_, c.z >> shift_};
    };
    return std::pair(cube(a), a) < std::pair(cube(b), b);
  }

 private:
  static constexpr std::size_t kFew = 1024;
  int shift_;
};

inline std::uint32_t countOf(const BlockMask& mask) {
  std::uint32_t count = 0;
  for (const std::uint64_t word : mask) count += static_cast<std::uint32_t>(std::popcount(word));
  return count;
}

/// The crossings of the lattice edges that begin in one block: one bit each. They are numbered from
/// `first` on in the order of the bits.
struct CrossingBlock {
  Coord coord;
  std::uint32_t first = 0;
  std::array<BlockMask, 3> edges{};  ///< along x, y, z, from each point to the next

  std::uint32_t count() const { return countOf(edges[0]) + countOf(edges[1]) + countOf(edges[2]); }
  std::uint32_t number(int axis, unsigned x, unsigned bit) const {
    std::uint32_t number = first;
    for (int i = 0; i < axis; ++i) number += countOf(edges[i]);
    for (unsigned i = 0; i < x; ++i) {
      number += static_cast<std::uint32_t>(std::popcount(edges[axis][i]));
    }
    return number + countBefore(edges[axis][x], bit);
  }
};

/// Crossings of the edges that begin in a block, at most.
inline constexpr std::uint32_t kMostInBlock = 3 * 512;

/// Numbers the crossings of a block from `first` on and returns the number after the last. Fails if
/// that exceeds 32 bits.
Result<std::uint32_t> numberFrom(std::uint32_t first, CrossingBlock& block);

/// A frame prepared for weaving: its numbered crossings and the blocks around its surface.
class FrameLayer {
 public:
  /// All points are outside: the frame before the first and after the last.
  FrameLayer() = default;
  /// Frames with `largeFrame` bytes of values or more keep them in a file. Fails if numberFrom or
  /// FrameFile does.
  static Result<FrameLayer> of(Frame frame, const Lattice& lattice, std::size_t largeFrame);

  double time() const { return frame_.time; }
  bool hasValues() const { return frame_.hasValues(); }
  /// Whether nothing tells how far inside a point is: there are no values, or only two of them
  /// where edges of the lattice are crossed.
  bool isMask() const { return !hasValues() || hasTwoValues_; }
  /// Whether the frame's values are float32, so that crossings are rounded (CrossingGrid).
  bool hasFloats() const { return hasFloats_; }
  /// The number of crossings, which are the vertices of the layer.
  std::uint32_t vertexCount() const { return vertexCount_; }
  /// Sets `into` to the crossings from number `first` on.
  void vertices(std::uint32_t first, std::span<model::Point4> into) const;

  BlockView view(const Coord& coord) const;
  /// The field in a block, as long as `buffer` is left alone. The frame has values.
  BlockField field(const Coord& coord, ValueBuffer& buffer) const;
  /// Fails if values could not be read back: what was made of them is wrong.
  Result<void> checkRead() const;
  /// The crossings of the edges that begin in a block; null if there are none.
  const CrossingBlock* crossings(const Coord& coord) const;

  /// All blocks with the lowest corner of a cube that has corners both inside and outside, and
  /// some beside them; in increasing order.
  const std::vector<Coord>& surfaceBlocks() const { return surfaceBlocks_; }
  /// Stored blocks that are entirely inside.
  const std::vector<Coord>& solidBlocks() const { return solidBlocks_; }
  std::size_t storedBlocks() const {
    return frame_.samples ? frame_.samples->blocks() : frame_.blocks.size();
  }
  const std::vector<InsideTile>& tiles() const { return frame_.tiles; }
  const IndexedFrame& frame() const { return frame_; }
  /// True if one tile of this frame covers all of `tile`.
  bool coversInside(const InsideTile& tile) const;

 private:
  /// The number of the first crossing of a block, or one more than the last.
  std::uint32_t firstOf(std::size_t block) const {
    return block < crossings_.size() ? crossings_[block].first : vertexCount_;
  }
  void findSolidBlocks();
  Result<void> findSurfaceBlocks();
  CrossingBlock crossingsIn(const Coord& coord) const;
  Result<void> numberCrossings();
  Result<void> keepFractions(std::size_t largeFrame);
  using Values = std::array<double, 2>;  // of the field at the ends of a crossed edge
  template <class Take>
  void eachCrossed(const CrossingBlock& block, Take take) const;
  bool findFractions(const CrossingBlock& block, const Values& first, double* into) const;
  void place(const CrossingBlock& block, const double* fractions, model::Point4* into) const;

  IndexedFrame frame_;
  std::vector<double> fractions_;               // of all crossings, if the frame has values
  std::unique_ptr<FrameFile> fractionsInFile_;  // instead, if it is large
  Lattice lattice_;
  std::vector<Coord> solidBlocks_;
  std::vector<Coord> surfaceBlocks_;
  std::vector<CrossingBlock> crossings_;  // in the order of their numbers
  CoordIndex crossingIndex_;
  std::uint32_t vertexCount_ = 0;
  bool hasFloats_ = false;
  bool hasTwoValues_ = false;
};

/// Crossings keep at least this distance from both ends of an edge, as a fraction of the edge, so
/// that no cell collapses where the surface passes through a lattice point.
inline constexpr double kOffLattice = 1e-3;

/// The zero of a field that is linear from a to b, exactly one of which is negative.
inline double crossing(double a, double b) {
  return std::clamp(a / (a - b), kOffLattice, 1 - kOffLattice);
}

/// Where values are float32, a crossing is placed to a millionth of the edge, about what they tell:
/// numbers with fewer digits take less space in a file.
class CrossingGrid {
 public:
  /// The edges have this length, which is not negative.
  explicit CrossingGrid(double length) {
    if (!(length > 0)) return;
    step_ = std::ldexp(1, std::ilogb(length) - kBits);
    inverse_ = 1 / step_;
  }

  /// Exact but for the rounding to a multiple of the step, a power of two.
  double nearest(double coordinate) const {
    // Doubles are whole numbers from here on; adding it rounds smaller values.
    constexpr double kWhole = 6755399441055744;  // 1.5 x 2^52
    const double steps = coordinate * inverse_;
    if (!(step_ > 0 && std::abs(steps) < kWhole / 3)) return coordinate;
    return ((steps + kWhole) - kWhole) * step_;
  }

 private:
  static constexpr int kBits = 20;
  double step_ = 0;
  double inverse_ = 0;
};

/// The 8 blocks at coordinate offsets 0 or +1: number d has x = d & 1, y = d >> 1, z = d >> 2.
inline Coord neighbour(const Coord& coord, unsigned d, std::int32_t by = 1) {
  return {coord.x + by * static_cast<std::int32_t>(d & 1U),
          coord.y + by * static_cast<std::int32_t>(d >> 1U & 1U),
          coord.z + by * static_cast<std::int32_t>(d >> 2U & 1U)};
}

/// The signs of the corners at offset d (as above) of the 512 cubes that begin in a block, from the
/// views of its 8 neighbours.
BlockMask shiftedSigns(const std::array<BlockView, 8>& views, unsigned d);

}  // namespace t4d::voxel4d
