#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "formats/t4d/index_chunk.h"

namespace t4d::formats {

/// The intact chunks found in a scan of a damaged file, and their offsets before bytes were
/// inserted or lost. Slabs refer to their parts by the distances between them at that time.
///
///      before    | CONN | LAYR | SLAB |      | LAYR | SLAB |
///      found     | CONN | LAYR | SLAB | ~~~~~~~~ | LAYR | SLAB |
///      moved by     0      0      0       gap       8      8
///
/// The index gives the original offset of each slab. Chunks next to a slab, with no gap between,
/// have moved as far as the slab; if the slabs on both sides disagree, the original offset is
/// unknown. A chunk whose header is not that of the index at its original offset is of another
/// file. Without an index, all chunks are assumed not to have moved, and slabs after the end mark
/// to be of another file.
class FoundChunks {
 public:
  struct FoundSlab {
    IndexRecord record;        ///< found at `record.slab`; its parts as stored in it
    std::uint64_t before = 0;  ///< original offset
  };

  /// Call in file order.
  void addPart(const ChunkHeader& header) { parts_.push_back({header, run_}); }
  void addSlab(const IndexRecord& record, std::uint32_t frontCrc) {
    found_.push_back({record, frontCrc, run_, parts_.size()});
  }
  /// Records DONE, which slabs of the file do not follow.
  void addEnd() { slabsBeforeEnd_ = std::min(slabsBeforeEnd_, found_.size()); }
  /// Records bytes that are not an intact chunk.
  void addGap() { ++run_; }

  /// Computes the original offsets. Drops duplicate slabs, and those that are not in the index,
  /// which has no chunks if it is lost.
  void compareWith(const Index& index);

  /// The slabs that were found, in their original order.
  const std::vector<FoundSlab>& slabs() const { return slabs_; }
  /// Slabs of the index that were not found, with the offsets where they should be.
  const std::vector<FoundSlab>& missing() const { return missing_; }
  /// The current offset of the part that was originally at `before`.
  std::optional<std::uint64_t> part(std::uint64_t before) const;
  /// The original offset of a part whose current offset that function gave.
  std::uint64_t before(std::uint64_t now) const { return before_.at(now); }

 private:
  struct Part {
    ChunkHeader header;
    std::uint64_t run = 0;  ///< number of the run of chunks without a gap
  };
  struct Slab {
    IndexRecord record;
    std::uint32_t frontCrc = 0;
    std::uint64_t run = 0;
    std::size_t partsBefore = 0;
    std::optional<std::uint64_t> before = {};
    bool again = false;  ///< or not of this file
  };
  void match(const Index& index);
  void placeMovedParts(const Index& index);
  void place(const ChunkHeader& part, std::uint64_t before, const Index& index);

  std::uint64_t run_ = 0;
  std::size_t slabsBeforeEnd_ = std::numeric_limits<std::size_t>::max();
  std::vector<Part> parts_;
  std::vector<Slab> found_;
  std::vector<FoundSlab> slabs_;
  std::vector<FoundSlab> missing_;
  std::map<std::uint64_t, std::uint64_t> now_;  // current offset of each part, by original offset
  std::map<std::uint64_t, std::uint64_t> before_;  // the other way round
};

}  // namespace t4d::formats
