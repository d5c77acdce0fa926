#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/t4d/array_codec.h"
#include "t4d/formats/t4d/chunk_header.h"
#include "t4d/formats/t4d/layout.h"
#include "t4d/formats/t4d/summary.h"
#include "t4d/model/error.h"
#include "t4d/model/slab.h"

/// The contents of each chunk of a .t4d file, with encoder and decoder side by side (SPEC.md,
/// section "Chunks"). Decoders check everything that can be checked without the rest of the file,
/// given the features the file names; their errors describe the fault and have no `where`. Payloads
/// are given without the table of their blocks.
namespace t4d::formats {

/// How arrays are stored.
struct ArrayOptions {
  int level = 3;         ///< zstd level; 0 for none
  bool float32 = false;  ///< store positions as float32
};

t4d_layout::PayloadWriter encodeConnectivity(const model::Connectivity& connectivity,
                                             const ArrayOptions& options);
Result<std::shared_ptr<const model::Connectivity>> decodeConnectivity(
    const t4d_layout::PayloadView& payload, t4d_layout::Features features = {});

t4d_layout::PayloadWriter encodeLayer(double time, std::span<const model::Point4> vertices,
                                      const ArrayOptions& options);

/// Vertices at one time, as stored.
struct Layer {
  double time = 0;
  PackedArray positions;  ///< points into the payload

  std::uint64_t size() const { return positions.rows; }
};
Result<Layer> decodeLayer(const t4d_layout::PayloadView& payload,
                          t4d_layout::Features features = {});

/// Writes the vertices of a layer to `into`, which must have the layer's size.
Result<void> unpackLayer(const Layer& layer, std::span<model::Point4> into);

/// Offsets of a slab's parts in the file; 0 for a layer without vertices.
struct SlabParts {
  std::uint64_t connectivity = 0;
  std::uint64_t lower = 0;
  std::uint64_t upper = 0;
  std::uint32_t body = 0;

  friend bool operator==(const SlabParts&, const SlabParts&) = default;
};

/// The vertices that a block of cells needs, those of means included: for each of the lower layer,
/// the interior and the upper layer the first and one more than the last; equal if there are none.
using BlockRanges = std::array<std::uint32_t, 6>;

/// The ranges of each block of cells; empty if there is at most one block.
std::vector<BlockRanges> rangesOfBlocks(const model::Connectivity& connectivity);

/// The slab as a file with positions of float32 gives it back: these rounded, and means of them.
model::Slab roundedSlab(const model::Slab& slab);

/// The bounds of the vertices of each block of cells; empty if there is at most one block.
std::vector<model::Bounds4> boundsOfBlocks(const model::Connectivity& connectivity,
                                           std::span<const model::Point4> vertices);

/// A slab without the parts it shares with others.
struct SlabChunk {
  model::TimeSpan time;
  SlabParts parts;
  std::vector<model::Bounds4> cellBounds;  ///< as boundsOfBlocks gives them
  std::vector<model::Point4> interior;     ///< the interior vertices that are not means
  std::vector<model::Attribute> attributes;
};

/// `slab` is as it is stored: rounded with float32.
t4d_layout::PayloadWriter encodeSlab(const model::Slab& slab, const SlabParts& parts,
                                     const ArrayOptions& options);
Result<SlabChunk> decodeSlab(const t4d_layout::PayloadView& payload,
                             t4d_layout::Features features = {});

/// Adds a slab, as it is stored, to the summary of its body.
void addSlab(BodySummary& body, const model::Slab& slab);

/// Checks the summary in the file against the slabs actually found. Slab count and times are left
/// to checkDone, which does not need the slabs.
Result<void> checkSummary(const BodySummary& said, const BodySummary& found);

/// The end mark, after all chunks that hold data.
struct Done {
  std::uint64_t chunks = 0;  ///< before this one
  std::vector<BodySummary> bodies;
};

t4d_layout::PayloadWriter encodeDone(const Done& done);
Result<Done> decodeDone(const t4d_layout::PayloadView& payload);

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
                          t4d_layout::Features features = {});

/// Checks that the attributes of a slab, those of its connectivity and its own, can be stored:
/// names are UTF-8 and not too long, names are unique within a domain, rows fit.
Result<void> checkStorable(std::span<const model::Attribute> ofConnectivity,
                           std::span<const model::Attribute> ofSlab);

}  // namespace t4d::formats
