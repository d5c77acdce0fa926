#include "voxel4d/frame_parts.h"

#include <algorithm>
#include <bit>

#include "model/parallel.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::voxel4d {
namespace {

using Piece = FrameParts::Piece;

constexpr std::uint64_t kFirstZ = 0x0101010101010101U;  // bits with z = 0

/// The points that are connected with the first one.
BlockMask connected(const BlockMask& points) {
  BlockMask found{};
  std::size_t first = 0;
  while (points[first] == 0) ++first;
  found[first] = points[first] & (~points[first] + 1);
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t i = 0; i < 16; ++i) {
      const std::size_t x = i < 8 ? i : 15 - i;  // there and back
      const std::uint64_t here = found[x];
      std::uint64_t next = here | here << 8U | here >> 8U | (here << 1U & ~kFirstZ) |
                           (here >> 1U & ~(kFirstZ << 7U));
      if (x > 0) next |= found[x - 1];
      if (x < 7) next |= found[x + 1];
      next &= points[x];
      grows = grows || next != here;
      found[x] = next;
    }
  }
  return found;
}

bool any(const BlockMask& points) {
  return std::ranges::any_of(points, [](std::uint64_t word) { return word != 0; });
}

std::vector<Piece> piecesIn(BlockMask points) {
  std::vector<Piece> pieces;
  while (any(points)) {
    // In noise, what is left counts as one.
    const bool last = pieces.size() + 1 == FrameParts::kMostPieces;
    pieces.push_back({last ? points : connected(points)});
    for (std::size_t x = 0; x < 8; ++x) points[x] &= ~pieces.back().points[x];
  }
  return pieces;
}

/// The points on a side of a block, as those that they touch on the other side of the next block.
BlockMask sideOf(const BlockMask& points, int axis, bool upper) {
  BlockMask side{};
  if (axis == 0) {
    side[0] = points[upper ? 7 : 0];
    return side;
  }
  for (std::size_t x = 0; x < 8; ++x) {
    side[x] = axis == 1 ? (upper ? points[x] >> 56U : points[x] & 0xFFU)
                        : (upper ? points[x] >> 7U : points[x]) & kFirstZ;
  }
  return side;
}

bool meet(const BlockMask& a, const BlockMask& b) {
  std::uint64_t both = 0;
  for (std::size_t x = 0; x < 8; ++x) both |= a[x] & b[x];
  return both != 0;
}

Coord moved(Coord coord, int axis, std::int32_t by) {
  (axis == 0 ? coord.x : axis == 1 ? coord.y : coord.z) += by;
  return coord;
}

/// What has no point in common with the other frame, as far as it must be known.
struct Alone {
  std::uint64_t voxels = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  model::Bounds3 bounds = {};

  Eigen::Vector3d centroid() const { return sum / static_cast<double>(voxels); }
  void add(const Eigen::Vector3d& point) {
    ++voxels;
    sum += point;
    bounds.add(point);
  }
  void add(const InsideTile& tile) {
    const double size = kBlockSize * static_cast<double>(tile.size);
    const Eigen::Vector3d first =
        kBlockSize * Eigen::Vector3d(tile.coord.x, tile.coord.y, tile.coord.z);
    const Eigen::Vector3d last = first + Eigen::Vector3d::Constant(size - 1);
    voxels += static_cast<std::uint64_t>(size * size * size);
    sum += size * size * size * (first + last) / 2;
    bounds.add(first);
    bounds.add(last);
  }
};

/// The parts that do not overlap, at most as many as are of use: the largest.
std::vector<Alone> aloneOf(const IndexedFrame& frame, const FrameParts& parts,
                           const std::vector<bool>& overlaps) {
  std::vector<std::uint32_t> number(parts.count(), model::kNoIndex);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (!overlaps[i]) number[i] = count++;
  }
  std::vector<Alone> alone(count);
  if (count == 0) return alone;
  for (std::uint32_t i = 0; i < frame.blocks.size(); ++i) {
    const Coord& coord = frame.blocks[i].coord;
    const Eigen::Vector3d first = kBlockSize * Eigen::Vector3d(coord.x, coord.y, coord.z);
    for (const Piece& piece : parts.piecesOf(i)) {
      if (number[piece.part] >= count) continue;
      for (unsigned x = 0; x < 8; ++x) {
        for (std::uint64_t left = piece.points[x]; left != 0; left &= left - 1) {
          const int bit = std::countr_zero(left);
          alone[number[piece.part]].add(first + Eigen::Vector3d(x, bit >> 3, bit & 7));
        }
      }
    }
  }
  for (std::uint32_t i = 0; i < frame.tiles.size(); ++i) {
    const std::uint32_t part = number[parts.partOfTile(i)];
    if (part < count) alone[part].add(frame.tiles[i]);
  }
  std::ranges::stable_sort(alone, std::ranges::greater(), &Alone::voxels);
  if (alone.size() > LostParts::kMostListed) alone.resize(LostParts::kMostListed);
  return alone;
}

}  // namespace

FrameParts::FrameParts(const IndexedFrame& frame) {
  const std::vector<Block>& blocks = frame.blocks;
  std::vector<std::vector<Piece>> found(blocks.size());
  model::forEach(blocks.size(), [&](std::size_t i) { found[i] = piecesIn(blocks[i].inside); });
  for (const std::vector<Piece>& pieces : found) {
    firstPiece_.push_back(static_cast<std::uint32_t>(pieces_.size()));
    pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
  }
  firstPiece_.push_back(static_cast<std::uint32_t>(pieces_.size()));

  const auto firstTile = static_cast<std::uint32_t>(pieces_.size());
  model::UnionFind sets(firstTile + frame.tiles.size());
  const auto uniteWithTile = [&](std::uint32_t tile, const Coord& beside, int axis, bool above) {
    if (const auto block = frame.blockAt(beside)) {
      for (std::uint32_t k = firstPiece_[*block]; k < firstPiece_[*block + 1]; ++k) {
        if (any(sideOf(pieces_[k].points, axis, !above))) sets.unite(firstTile + tile, k);
      }
    } else if (const auto other = frame.tileAt(beside)) {
      sets.unite(firstTile + tile, firstTile + *other);
    }
  };
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto next = frame.blockAt(moved(blocks[i].coord, axis, 1));
      if (!next) continue;
      for (std::uint32_t k = firstPiece_[i]; k < firstPiece_[i + 1]; ++k) {
        const BlockMask side = sideOf(pieces_[k].points, axis, true);
        if (!any(side)) continue;
        for (std::uint32_t m = firstPiece_[*next]; m < firstPiece_[*next + 1]; ++m) {
          if (meet(side, sideOf(pieces_[m].points, axis, false))) sets.unite(k, m);
        }
      }
    }
  }
  for (std::uint32_t i = 0; i < frame.tiles.size(); ++i) {
    const InsideTile& tile = frame.tiles[i];
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool above : {false, true}) {
        const Coord corner = moved(tile.coord, axis, above ? tile.size : -1);
        for (std::int32_t u = 0; u < tile.size; ++u) {
          for (std::int32_t v = 0; v < tile.size; ++v) {
            uniteWithTile(i, moved(moved(corner, (axis + 1) % 3, u), (axis + 2) % 3, v), axis,
                          above);
          }
        }
      }
    }
  }

  std::vector<std::uint32_t> number(firstTile + frame.tiles.size());
  const auto partOf = [&](std::uint32_t item) {
    const std::uint32_t root = sets.root(item);  // the smallest of its set
    if (root == item) number[item] = static_cast<std::uint32_t>(count_++);
    return number[root];
  };
  for (std::uint32_t i = 0; i < firstTile; ++i) pieces_[i].part = partOf(i);
  for (std::uint32_t i = 0; i < frame.tiles.size(); ++i) tiles_.push_back(partOf(firstTile + i));
}

void addPartsLost(const IndexedFrame& before, const FrameParts& partsBefore,
                  const IndexedFrame& after, const FrameParts& partsAfter, std::size_t number,
                  const model::Affine3x4& place, LostParts& into) {
  std::vector<bool> ofBefore(partsBefore.count());  // whether a part has a point in the other frame
  std::vector<bool> ofAfter(partsAfter.count());
  const auto overlap = [&](std::uint32_t a, std::uint32_t b) {
    ofBefore[a] = true;
    ofAfter[b] = true;
  };
  for (std::uint32_t i = 0; i < before.blocks.size(); ++i) {
    const auto pieces = partsBefore.piecesOf(i);
    if (pieces.empty()) continue;
    const Coord& coord = before.blocks[i].coord;
    if (const auto block = after.blockAt(coord)) {
      for (const Piece& a : pieces) {
        for (const Piece& b : partsAfter.piecesOf(*block)) {
          if (ofBefore[a.part] && ofAfter[b.part]) continue;
          if (meet(a.points, b.points)) overlap(a.part, b.part);
        }
      }
    } else if (const auto tile = after.tileAt(coord)) {
      for (const Piece& a : pieces) overlap(a.part, partsAfter.partOfTile(*tile));
    }
  }
  for (std::uint32_t i = 0; i < after.blocks.size(); ++i) {
    const auto pieces = partsAfter.piecesOf(i);
    if (pieces.empty() || before.blockAt(after.blocks[i].coord)) continue;
    if (const auto tile = before.tileAt(after.blocks[i].coord)) {
      for (const Piece& b : pieces) overlap(partsBefore.partOfTile(*tile), b.part);
    }
  }
  for (std::uint32_t i = 0; i < before.tiles.size(); ++i) {
    if (const auto tile = after.tileAt(before.tiles[i].coord)) {
      overlap(partsBefore.partOfTile(i), partsAfter.partOfTile(*tile));
    }
  }
  for (std::uint32_t i = 0; i < after.tiles.size(); ++i) {
    if (const auto tile = before.tileAt(after.tiles[i].coord)) {
      overlap(partsBefore.partOfTile(*tile), partsAfter.partOfTile(i));
    }
  }

  const std::vector<Alone> ended = aloneOf(before, partsBefore, ofBefore);
  if (ended.empty()) return;
  const std::vector<Alone> begun = aloneOf(after, partsAfter, ofAfter);
  for (const Alone& a : ended) {
    const double extent = (a.bounds.max - a.bounds.min).maxCoeff() + 1;
    const double near = std::max<double>(kBlockSize, 2 * extent);
    const bool goesOn = std::ranges::any_of(begun, [&](const Alone& b) {
      return b.voxels <= 2 * a.voxels && a.voxels <= 2 * b.voxels &&
             (b.centroid() - a.centroid()).norm() <= near;
    });
    if (!goesOn) continue;
    ++into.count;
    if (into.listed.size() == LostParts::kMostListed) continue;
    into.listed.push_back({number, before.time, place * a.centroid().homogeneous(), a.voxels});
  }
}

}  // namespace t4d::voxel4d
