#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/t4d/chunk_header.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/layout.h"
#include "formats/t4d/long_list.h"
#include "t4d/error.h"
#include "t4d/mesh.h"

/// INDX, with encoder and decoder side by side (SPEC.md, section "INDX").
namespace t4d::formats {

/// The contents of a slab as the index gives them.
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

/// An IndexRecord as it is kept in a LongList.
struct PlainRecord {
  PlainRecord() = default;
  explicit PlainRecord(const IndexRecord& record);
  explicit operator IndexRecord() const;

  std::uint64_t slab = 0;
  std::uint64_t slabBytes = 0;
  SlabParts parts;
  model::TimeSpan time;
  bool hasExtent = false;
  std::uint64_t cells = 0;
  std::array<double, 6> bounds{};
};

using ChunkList = LongList<ChunkHeader>;
using SlabList = LongList<IndexRecord, PlainRecord>;

/// The beginning of INDX.
struct IndexFront {
  std::array<std::byte, t4d_layout::kFileHeaderCopyBytes> fileHeader{};
  std::string head;  ///< the payload of HEAD
};

/// The contents of INDX.
struct Index : IndexFront {
  std::vector<ChunkHeader> chunks;  ///< those before INDX
  std::vector<IndexRecord> slabs;   ///< each has an extent
};

/// Arrays of INDX that PAGE has, too: the directory of chunks.
void putHeaders(t4d_layout::PayloadWriter& into, const Rows<ChunkHeader>& chunks, int level);
/// Chunks that follow one another from `offset` on.
Result<std::vector<ChunkHeader>> takeHeaders(t4d_layout::PayloadReader& from,
                                             const t4d_layout::Features& features,
                                             std::uint64_t offset);
/// The records of the slabs, except for the offset and size of their chunks.
void putSlabs(t4d_layout::PayloadWriter& into, const Rows<IndexRecord>& slabs, int level);
Result<void> takeSlabs(t4d_layout::PayloadReader& from, std::span<IndexRecord> slabs,
                       const t4d_layout::Features& features);
/// Sets place and size of each slab, which is to be one of the chunks, as are its parts.
Result<void> placeSlabs(const std::vector<ChunkHeader>& chunks, std::span<IndexRecord> slabs);

/// `chunks` are those before INDX.
t4d_layout::PayloadWriter encodeIndex(const IndexFront& front, const Rows<ChunkHeader>& chunks,
                                      const Rows<IndexRecord>& slabs, int level);
t4d_layout::PayloadWriter encodeIndex(const Index& index, int level);
/// The beginning alone, and the number of slabs.
Result<IndexFront> takeIndexFront(t4d_layout::PayloadReader& from, std::uint32_t& slabs);
/// Fails if a payload is not that of encodeIndex, however its arrays are stored.
Result<void> compareIndex(const t4d_layout::PayloadView& payload,
                          const t4d_layout::Features& features, const IndexFront& front,
                          const Rows<ChunkHeader>& chunks, const Rows<IndexRecord>& slabs);
/// Fails if the chunks cannot be one after another from the file header on, if there are more or
/// fewer slabs among them than records, and if a part of a slab is none of them.
Result<Index> decodeIndex(const t4d_layout::PayloadView& payload,
                          const t4d_layout::Features& features = {});

}  // namespace t4d::formats
