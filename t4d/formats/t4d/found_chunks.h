#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "t4d/formats/t4d/index_chunk.h"

namespace t4d::formats {

/// The intact chunks found in a scan of a damaged file, and their offsets before bytes were
/// inserted or lost. Those offsets are how slabs refer to their parts.
///
///      before    | CONN | LAYR | SLAB |      | LAYR | SLAB |
///      found     | CONN | LAYR | SLAB | ~~~~~~~~ | LAYR | SLAB |
///      moved by     0      0      0       gap       8      8
///
/// The index gives the original offset of each slab. Chunks next to a slab, with no gap between,
/// have moved as far as the slab; if the slabs on both sides disagree, the original offset is
/// unknown. Without an index, all chunks are assumed not to have moved.
class FoundChunks {
 public:
  struct FoundSlab {
    IndexRecord record;        ///< found at `record.slab`; its parts as stored in it
    std::uint64_t before = 0;  ///< original offset
  };

  /// Call in file order.
  void addPart(std::uint64_t offset) { parts_.push_back({offset, run_}); }
  void addSlab(const IndexRecord& record) { found_.push_back({record, run_, parts_.size()}); }
  /// Records bytes that are not an intact chunk.
  void addGap() { ++run_; }

  /// Computes the original offsets. Drops duplicate slabs, and slabs that have moved and are not in
  /// the index.
  void compareWith(std::span<const IndexRecord> index);

  /// In their original order.
  const std::vector<FoundSlab>& slabs() const { return slabs_; }
  /// Slabs of the index that were not found, with the offsets where they should be.
  const std::vector<FoundSlab>& missing() const { return missing_; }
  /// The current offset of the part that was originally at `before`.
  std::optional<std::uint64_t> part(std::uint64_t before) const;

 private:
  struct Part {
    std::uint64_t offset = 0;
    std::uint64_t run = 0;  ///< number of the run of chunks without a gap
  };
  struct Slab {
    IndexRecord record;
    std::uint64_t run = 0;
    std::size_t partsBefore = 0;
    std::optional<std::uint64_t> before = {};
    bool again = false;
  };
  void match(std::span<const IndexRecord> index);
  void placeMovedParts();

  std::uint64_t run_ = 0;
  std::vector<Part> parts_;
  std::vector<Slab> found_;
  std::vector<FoundSlab> slabs_;
  std::vector<FoundSlab> missing_;
  std::map<std::uint64_t, std::uint64_t> now_;  // current offset of each part, by original offset
};

}  // namespace t4d::formats
