#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "t4d/formats/t4d/chunks.h"

namespace t4d::formats {

/// The whole chunks that a walk over a damaged file has found, and where they were before bytes
/// were inserted or went missing: slabs name their parts by those offsets.
///
///      before    | CONN | LAYR | SLAB |      | LAYR | SLAB |
///      found     | CONN | LAYR | SLAB | ~~~~~~~~ | LAYR | SLAB |
///      moved by     0      0      0       gap       8      8
///
/// The index says where each slab was. What lies next to a slab, no gap between, has moved as far
/// as the slab; where the slabs on both sides say different things, nothing is said. Without an
/// index all is taken to be where it was.
class FoundChunks {
 public:
  struct FoundSlab {
    IndexRecord record;        ///< found at `record.slab`; its parts as it names them
    std::uint64_t before = 0;  ///< where it was
  };

  /// In file order.
  void addPart(std::uint64_t offset) { parts_.push_back({offset, run_}); }
  void addSlab(const IndexRecord& record) { found_.push_back({record, run_, parts_.size()}); }
  /// Something that is no whole chunk.
  void addGap() { ++run_; }

  /// Finds out what was where. A slab that is there twice, or that has moved and is not in the
  /// index, is left out.
  void compareWith(std::span<const IndexRecord> index);

  /// In the order in which they were.
  const std::vector<FoundSlab>& slabs() const { return slabs_; }
  /// Those of the index that were not found, with the places where they should be.
  const std::vector<FoundSlab>& missing() const { return missing_; }
  /// Where the part is now that was at `before`.
  std::optional<std::uint64_t> part(std::uint64_t before) const;

 private:
  struct Part {
    std::uint64_t offset = 0;
    std::uint64_t run = 0;  ///< of chunks without a gap
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
  std::map<std::uint64_t, std::uint64_t> now_;  // of parts, by where they were
};

}  // namespace t4d::formats
