#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/t4d/chunk_header.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/formats/t4d/layout.h"
#include "t4d/model/error.h"
#include "t4d/model/slab.h"

/// INDX, with encoder and decoder side by side (SPEC.md, section "INDX").
namespace t4d::formats {

/// What the index says about the contents of a slab.
struct SlabExtent {
  std::uint64_t cells = 0;
  model::Bounds3 bounds;  ///< of all its vertices

  friend bool operator==(const SlabExtent& a, const SlabExtent& b) {
    return a.cells == b.cells && a.bounds.min == b.bounds.min && a.bounds.max == b.bounds.max;
  }
};
SlabExtent extentOf(const model::Slab& slab);

/// The location of one slab, in file order.
struct IndexRecord {
  std::uint64_t slab = 0;       ///< offset of the slab's chunk
  std::uint64_t slabBytes = 0;  ///< size of the chunk, including header and padding
  SlabParts parts;
  model::TimeSpan time;
  std::optional<SlabExtent> extent = {};  ///< in a record of the index

  /// The offsets of its parts; 0 for a layer without vertices.
  std::uint64_t connectivity() const { return slab - parts.connectivity; }
  std::uint64_t lower() const { return parts.lower == 0 ? 0 : slab - parts.lower; }
  std::uint64_t upper() const { return parts.upper == 0 ? 0 : slab - parts.upper; }

  /// Whether place, parts and times are the same; the extent is known only to the index.
  friend bool operator==(const IndexRecord& a, const IndexRecord& b) {
    return a.slab == b.slab && a.slabBytes == b.slabBytes && a.parts == b.parts &&
           a.time.begin == b.time.begin && a.time.end == b.time.end;
  }
};

/// The contents of INDX.
struct Index {
  std::array<std::byte, t4d_layout::kFileHeaderCopyBytes> fileHeader{};
  std::string head;                 ///< the payload of HEAD
  std::vector<ChunkHeader> chunks;  ///< those before INDX
  std::vector<IndexRecord> slabs;   ///< each has an extent
};

t4d_layout::PayloadWriter encodeIndex(const Index& index, int level);
/// Fails if the chunks cannot be one after another from the file header on, if there are more or
/// fewer slabs among them than records, and if a part of a slab is none of them.
Result<Index> decodeIndex(const t4d_layout::PayloadView& payload,
                          const t4d_layout::Features& features = {});

}  // namespace t4d::formats
