#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/weave.h"
#include "voxel4d/indexed_frame.h"

namespace t4d::voxel4d {

/// The parts of a frame: lattice points inside, connected by edges of the lattice.
class FrameParts {
 public:
  FrameParts() = default;
  explicit FrameParts(const IndexedFrame& frame);

  /// Pieces of a block, at most: in noise, more count as one.
  static constexpr std::size_t kMostPieces = 64;

  /// Connected points of one block.
  struct Piece {
    BlockMask points{};
    std::uint32_t part = 0;
  };

  /// The number of parts, which are numbered from 0 on.
  std::size_t count() const { return count_; }
  std::span<const Piece> piecesOf(std::uint32_t block) const {
    return std::span(pieces_).subspan(firstPiece_[block],
                                      firstPiece_[block + 1] - firstPiece_[block]);
  }
  std::uint32_t partOfTile(std::uint32_t tile) const { return tiles_[tile]; }

 private:
  std::vector<Piece> pieces_;              // of the blocks, one after another
  std::vector<std::uint32_t> firstPiece_;  // of each block, and one more
  std::vector<std::uint32_t> tiles_;       // the part of each
  std::size_t count_ = 0;
};

/// Adds the parts that are lost between two frames, `number` being that of the first; `place` maps
/// lattice points to space. A part that begins is near one that ends if its centroid is within
/// twice the extent of that, or 8 voxels, and of like size if it has half to twice as many voxels.
void addPartsLost(const IndexedFrame& before, const FrameParts& partsBefore,
                  const IndexedFrame& after, const FrameParts& partsAfter, std::size_t number,
                  const model::Affine3x4& place, LostParts& into);

}  // namespace t4d::voxel4d
