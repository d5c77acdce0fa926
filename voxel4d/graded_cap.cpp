#include "voxel4d/graded_cap.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <unordered_set>

#include <fmt/format.h>

#include "model/parallel.h"
#include "voxel4d/pattern_table.h"

namespace t4d::voxel4d {
namespace {

using model::Cell;
using model::Point4;

/// A cube of the octree: its lowest corner and its size, a power of two.
struct Leaf {
  Coord corner;
  std::int32_t size = 1;
};

/// The coordinate of `coord` along an axis (0 to 2).
std::int32_t& along(Coord& coord, int axis) {
  return axis == 0 ? coord.x : axis == 1 ? coord.y : coord.z;
}

Coord moved(Coord coord, int axis, std::int32_t by) {
  along(coord, axis) += by;
  return coord;
}

Coord parentOf(const Coord& node) { return {node.x >> 1U, node.y >> 1U, node.z >> 1U}; }

/// A numbered set of lattice points.
class LatticePoints {
 public:
  void add(const Coord& point) {
    blocks_[blockOf(point)].points[point.x & 7] |= std::uint64_t{1} << bitOf(point);
  }

  bool contains(const Coord& point) const {
    const PointBlock* block = find(blockOf(point));
    return block != nullptr && (block->points[point.x & 7] >> bitOf(point) & 1U) != 0;
  }

  /// Numbers the points by block; returns how many there are.
  std::uint64_t number() {
    order_.clear();
    for (auto& [coord, block] : blocks_) order_.push_back(coord);
    std::sort(order_.begin(), order_.end());
    std::uint64_t next = 0;
    for (const Coord& coord : order_) {
      PointBlock& block = blocks_[coord];
      for (unsigned x = 0; x < 8; ++x) {
        block.first[x] = static_cast<std::uint32_t>(next);
        next += static_cast<unsigned>(std::popcount(block.points[x]));
      }
    }
    return next;
  }

  /// The number of a point that the set contains.
  std::uint32_t numberOf(const Coord& point) const {
    const PointBlock& block = *find(blockOf(point));
    return block.first[point.x & 7] + countBefore(block.points[point.x & 7], bitOf(point));
  }

  /// Calls `visit` with each point, in the order of their numbers.
  template <class Visit>
  void forEach(Visit visit) const {
    for (const Coord& coord : order_) {
      const PointBlock& block = *find(coord);
      for (std::int32_t x = 0; x < kBlockSize; ++x) {
        for (std::uint64_t bits = block.points[x]; bits != 0; bits &= bits - 1) {
          const std::int32_t bit = std::countr_zero(bits);
          visit(Coord{kBlockSize * coord.x + x, kBlockSize * coord.y + (bit >> 3),
                      kBlockSize * coord.z + (bit & 7)});
        }
      }
    }
  }

 private:
  struct PointBlock {
    BlockMask points{};
    std::array<std::uint32_t, 8> first{};  // number of the first point in each word
  };

  static Coord blockOf(const Coord& point) { return {point.x >> 3U, point.y >> 3U, point.z >> 3U}; }
  static unsigned bitOf(const Coord& point) {
    return static_cast<unsigned>((point.y & 7) << 3 | (point.z & 7));
  }
  const PointBlock* find(const Coord& coord) const {
    const auto found = blocks_.find(coord);
    return found == blocks_.end() ? nullptr : &found->second;
  }

  std::unordered_map<Coord, PointBlock, CoordHash> blocks_;
  std::vector<Coord> order_;
};

/// A block in which cubes begin that have corners both inside and outside.
struct SurfaceBlock {
  Coord coord;
  /// Cubes divided by the table: the index of their lowest point in the block, and the signs of
  /// their corners.
  std::vector<std::pair<std::uint16_t, std::uint8_t>> cubes;
  std::vector<Leaf> leaves;  // those that are merged
  std::uint64_t firstCell = 0;
};

/// Merges the blocks that are all inside, cubes of 8 as well, into the largest cubes of the octree.
/// Tiles are divided only as far as the surface requires.
class BlockOctree {
 public:
  BlockOctree(const FrameLayer& layer, std::span<const SurfaceBlock> surface) {
    for (const SurfaceBlock& block : surface) {
      Coord node = block.coord;
      for (std::size_t level = 0; level < kLevels; ++level, node = parentOf(node)) {
        if (!surface_[level].insert(node).second) break;
      }
    }
    for (const Coord& coord : layer.solidBlocks()) add(coord, 0);
    for (const InsideTile& tile : layer.tiles()) {
      const int level = std::countr_zero(static_cast<std::uint32_t>(tile.size));
      add({tile.coord.x >> level, tile.coord.y >> level, tile.coord.z >> level},
          static_cast<std::size_t>(level));
    }
  }

  std::vector<Leaf> leaves() {
    std::vector<Leaf> leaves;
    for (std::size_t level = 0; level < kLevels; ++level) {
      std::vector<Coord>& nodes = solid_[level];
      std::sort(nodes.begin(), nodes.end(), [](const Coord& a, const Coord& b) {
        const Coord ofA = parentOf(a);
        const Coord ofB = parentOf(b);
        return ofA != ofB ? ofA < ofB : a < b;
      });
      for (std::size_t i = 0; i < nodes.size();) {
        const Coord parent = parentOf(nodes[i]);
        std::size_t end = i + 1;
        while (end < nodes.size() && parentOf(nodes[end]) == parent) ++end;
        constexpr std::size_t kChildren = 8;
        if (end - i == kChildren && level + 1 < kLevels) {
          solid_[level + 1].push_back(parent);
        } else {
          const std::int32_t size = kBlockSize << level;
          for (std::size_t k = i; k < end; ++k) {
            leaves.push_back({{nodes[k].x * size, nodes[k].y * size, nodes[k].z * size}, size});
          }
        }
        i = end;
      }
    }
    return leaves;
  }

 private:
  /// Sizes up to 2^30 points: 32-bit coordinates have no room for more.
  static constexpr std::size_t kLevels = 28;

  void add(const Coord& node, std::size_t level) {
    if (!surface_[level].contains(node)) {
      solid_[level].push_back(node);
      return;
    }
    if (level == 0) return;  // its cubes are merged one by one
    for (unsigned d = 0; d < 8; ++d) {
      add(neighbour({2 * node.x, 2 * node.y, 2 * node.z}, d), level - 1);
    }
  }

  // By level: nodes of 2^level blocks that contain a block at the surface, and nodes all inside.
  std::array<std::unordered_set<Coord, CoordHash>, kLevels> surface_;
  std::array<std::vector<Coord>, kLevels> solid_;
};

/// Removes the cubes that can be merged into one of `size` from `solid` and adds it to `leaves`.
void mergeCubes(const Coord& block, std::int32_t size, BlockMask& solid,
                std::vector<Leaf>& leaves) {
  const std::uint64_t square = size == 4 ? 0x0F0F0F0FU : 0x0303U;
  for (std::int32_t x = 0; x < kBlockSize; x += size) {
    for (std::int32_t y = 0; y < kBlockSize; y += size) {
      for (std::int32_t z = 0; z < kBlockSize; z += size) {
        const std::uint64_t face = square << static_cast<unsigned>(8 * y + z);
        const auto words = std::span(solid).subspan(x, size);
        if (!std::all_of(words.begin(), words.end(),
                         [&](std::uint64_t word) { return (word & face) == face; })) {
          continue;
        }
        for (std::uint64_t& word : words) word &= ~face;
        leaves.push_back(
            {{kBlockSize * block.x + x, kBlockSize * block.y + y, kBlockSize * block.z + z}, size});
      }
    }
  }
}

/// Leaves a block empty whose cubes are all inside or all outside.
void findCubes(const FrameLayer& layer, SurfaceBlock& block) {
  std::array<BlockView, 8> views;
  for (unsigned d = 0; d < 8; ++d) views[d] = layer.view(neighbour(block.coord, d));
  std::array<BlockMask, 8> corners;
  for (unsigned d = 0; d < 8; ++d) corners[d] = shiftedSigns(views, d);
  BlockMask solid = corners[0];
  BlockMask mixed = corners[0];
  for (unsigned x = 0; x < 8; ++x) {
    for (const BlockMask& corner : corners) {
      solid[x] &= corner[x];
      mixed[x] |= corner[x];
    }
    mixed[x] &= ~solid[x];
  }
  if (mixed == BlockMask{}) return;
  for (const std::int32_t size : {4, 2}) mergeCubes(block.coord, size, solid, block.leaves);
  for (unsigned x = 0; x < 8; ++x) {
    for (std::uint64_t bits = mixed[x] | solid[x]; bits != 0; bits &= bits - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(bits));
      unsigned signs = 0;
      for (unsigned d = 0; d < 8; ++d) {
        signs |= static_cast<unsigned>(corners[d][x] >> bit & 1U) << d;
      }
      block.cubes.emplace_back(static_cast<std::uint16_t>(x << 6U | bit),
                               static_cast<std::uint8_t>(signs));
    }
  }
}

class CapBuilder {
 public:
  CapBuilder(const FrameLayer& layer, const Lattice& lattice, CapEnd end)
      : layer_(layer), lattice_(lattice), first_(end == CapEnd::First) {}

  Result<model::Slab> build() {
    findLeaves();
    addCorners();
    cornerCount_ = corners_.number();
    layerCount_ = layer_.vertexCount();
    for (const Leaf& leaf : leaves_) addCone(leaf);
    for (const SurfaceBlock& block : blocks_) {
      for (const Leaf& leaf : block.leaves) addCone(leaf);
    }
    const std::uint64_t interior = cornerCount_ + centres_.size();
    std::uint64_t cells = cells_.size();
    for (SurfaceBlock& block : blocks_) {
      block.firstCell = cells;
      for (const auto& [index, signs] : block.cubes) cells += PatternTable::count(patternOf(signs));
    }
    const std::uint64_t vertices = interior + layerCount_;
    if (std::max(vertices, cells) > std::numeric_limits<std::uint32_t>::max()) {
      return invalid(
          fmt::format("a cap would have {} vertices and {} cells; at most 4294967295 are possible",
                      vertices, cells));
    }
    cells_.resize(cells);
    model::forEach(blocks_.size(), [&](std::size_t i) { emitCells(blocks_[i]); });
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = static_cast<std::uint32_t>(vertices);
    (first_ ? connectivity->upperCount : connectivity->lowerCount) =
        static_cast<std::uint32_t>(layerCount_);
    connectivity->cells = std::move(cells_);
    model::Slab slab;
    slab.timeBegin = layer_.time();
    slab.timeEnd = layer_.time();
    slab.connectivity = std::move(connectivity);
    slab.vertices = positions();
    return slab;
  }

 private:
  void findLeaves() {
    blocks_.resize(layer_.surfaceBlocks().size());
    model::forEach(blocks_.size(), [&](std::size_t i) {
      blocks_[i].coord = layer_.surfaceBlocks()[i];
      findCubes(layer_, blocks_[i]);
    });
    std::erase_if(blocks_, [](const SurfaceBlock& block) { return block.cubes.empty(); });
    leaves_ = BlockOctree(layer_, blocks_).leaves();
  }

  /// The corners of all cubes that are inside.
  void addCorners() {
    const auto addLeaf = [&](const Leaf& leaf) {
      for (unsigned d = 0; d < 8; ++d) corners_.add(neighbour(leaf.corner, d, leaf.size));
    };
    for (const Leaf& leaf : leaves_) addLeaf(leaf);
    for (const SurfaceBlock& block : blocks_) {
      for (const Leaf& leaf : block.leaves) addLeaf(leaf);
      for (const auto& [index, signs] : block.cubes) {
        const Coord corner = cornerOf(block, index);
        for (unsigned d = 0; d < 8; ++d) {
          if ((signs >> d & 1U) != 0) corners_.add(neighbour(corner, d));
        }
      }
    }
  }

  static Coord cornerOf(const SurfaceBlock& block, unsigned index) {
    return {kBlockSize * block.coord.x + static_cast<std::int32_t>(index >> 6U),
            kBlockSize * block.coord.y + static_cast<std::int32_t>(index >> 3U & 7U),
            kBlockSize * block.coord.z + static_cast<std::int32_t>(index & 7U)};
  }

  unsigned patternOf(unsigned signs) const { return first_ ? signs << 8U : signs; }

  /// The vertex of interior point `number`: a corner, or one of the centres after them.
  std::uint32_t interiorVertex(std::uint64_t number) const {
    return static_cast<std::uint32_t>(first_ ? number : layerCount_ + number);
  }
  std::uint32_t cornerVertex(const Coord& point) const {
    return interiorVertex(corners_.numberOf(point));
  }
  std::uint32_t addCentre(const Coord& point) {
    centres_.push_back(point);
    return interiorVertex(cornerCount_ + centres_.size() - 1);
  }

  void addCone(const Leaf& leaf) {
    const std::int32_t half = leaf.size / 2;
    apex_ = addCentre({leaf.corner.x + half, leaf.corner.y + half, leaf.corner.z + half});
    for (int axis = 0; axis < 3; ++axis) {
      addFace(leaf.corner, leaf.size, axis, false);
      addFace(moved(leaf.corner, axis, leaf.size), leaf.size, axis, true);
    }
  }

  /// Joins a face, or a square of one, to the apex. It is perpendicular to `axis` and its lowest
  /// corner is `corner`; `above`: it bounds the cube in the direction of the axis.
  void addFace(const Coord& corner, std::int32_t size, int axis, bool above) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const std::int32_t half = size / 2;
    const Coord centre = moved(moved(corner, u, half), v, half);
    if (size > 1 && corners_.contains(centre)) {
      addFace(corner, half, axis, above);
      addFace(moved(corner, u, half), half, axis, above);
      addFace(moved(corner, v, half), half, axis, above);
      addFace(centre, half, axis, above);
      return;
    }
    // Counter-clockwise, seen against the axis.
    const Coord opposite = moved(moved(corner, u, size), v, size);
    outline_.clear();
    addEdge(corner, u, size);
    addEdge(moved(corner, u, size), v, size);
    addEdge(opposite, u, -size);
    addEdge(moved(corner, v, size), v, -size);
    if (outline_.size() == 4) {
      addCell(outline_[0], outline_[1], outline_[2], above);
      addCell(outline_[0], outline_[2], outline_[3], above);
      return;
    }
    const auto [found, isNew] = faceCentres_.try_emplace(centre, 0);
    if (isNew) found->second = addCentre(centre);
    for (std::size_t i = 0; i < outline_.size(); ++i) {
      addCell(found->second, outline_[i], outline_[(i + 1) % outline_.size()], above);
    }
  }

  /// Adds the points of an edge to the outline, without its end.
  void addEdge(const Coord& begin, int axis, std::int32_t length) {
    const Coord middle = moved(begin, axis, length / 2);
    if (std::abs(length) > 1 && corners_.contains(middle)) {
      addEdge(begin, axis, length / 2);
      addEdge(middle, axis, length / 2);
    } else {
      outline_.push_back(cornerVertex(begin));
    }
  }

  /// `a`, `b`, `c` are counter-clockwise seen from outside the leaf if `outwards`. The normal of
  /// the first cap points back in time, that of the last one forward.
  void addCell(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool outwards) {
    if (outwards != first_) std::swap(b, c);
    cells_.push_back({apex_, a, b, c});
  }

  void emitCells(const SurfaceBlock& block) {
    Cell* into = cells_.data() + block.firstCell;
    std::array<const CrossingBlock*, 8> crossings{};
    for (unsigned d = 0; d < 8; ++d) crossings[d] = layer_.crossings(neighbour(block.coord, d));
    const auto firstOfLayer =
        static_cast<std::uint32_t>(first_ ? cornerCount_ + centres_.size() : 0);
    std::array<std::uint32_t, kEdges> vertex{};
    for (const auto& [index, signs] : block.cubes) {
      const unsigned pattern = patternOf(signs);
      for (std::uint32_t edges = PatternTable::edges(pattern); edges != 0; edges &= edges - 1) {
        const int edge = std::countr_zero(edges);
        const auto corner = static_cast<unsigned>(edgeCorner(edge)) & 7U;
        if (edgeAxis(edge) == 3) {
          vertex[edge] = cornerVertex(neighbour(cornerOf(block, index), corner));
          continue;
        }
        const unsigned x = (index >> 6U) + (corner & 1U);
        const unsigned y = (index >> 3U & 7U) + (corner >> 1U & 1U);
        const unsigned z = (index & 7U) + (corner >> 2U & 1U);
        vertex[edge] =
            firstOfLayer + crossings[x >> 3U | (y >> 3U) << 1U | (z >> 3U) << 2U]->number(
                               edgeAxis(edge), x & 7U, (y & 7U) << 3U | (z & 7U));
      }
      for (const auto& [a, b, c, d] : PatternTable::tetrahedra(pattern)) {
        *into++ = {vertex[a], vertex[b], vertex[c], vertex[d]};
      }
    }
  }

  std::vector<Point4> positions() const {
    const std::uint64_t interior = cornerCount_ + centres_.size();
    std::vector<Point4> all(interior + layerCount_);
    layer_.vertices(0, std::span(all).subspan(first_ ? interior : 0, layerCount_));
    std::uint64_t next = first_ ? 0 : layerCount_;
    const auto add = [&](const Coord& point) {
      all[next++] << lattice_(Eigen::Vector3d(point.x, point.y, point.z)), layer_.time();
    };
    corners_.forEach(add);
    for (const Coord& centre : centres_) add(centre);
    return all;
  }

  const FrameLayer& layer_;
  const Lattice& lattice_;
  bool first_;
  std::vector<Leaf> leaves_;  // of whole blocks
  std::vector<SurfaceBlock> blocks_;
  LatticePoints corners_;
  std::uint64_t cornerCount_ = 0;
  std::uint64_t layerCount_ = 0;
  std::vector<Coord> centres_;  // of leaves and faces
  std::unordered_map<Coord, std::uint32_t, CoordHash> faceCentres_;
  std::vector<Cell> cells_;
  std::uint32_t apex_ = 0;              // of the leaf that is divided
  std::vector<std::uint32_t> outline_;  // of the face that is divided
};

}  // namespace

Result<model::Slab> gradedCap(const FrameLayer& layer, const Lattice& lattice, CapEnd end) {
  return CapBuilder(layer, lattice, end).build();
}

}  // namespace t4d::voxel4d
