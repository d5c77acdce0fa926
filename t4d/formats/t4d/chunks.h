#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "t4d/formats/t4d/array_codec.h"
#include "t4d/formats/t4d/layout.h"
#include "t4d/formats/t4d/summary.h"
#include "t4d/model/error.h"
#include "t4d/model/slab.h"

/// The contents of each chunk of a .t4d file, with encoder and decoder side by side (SPEC.md,
/// section "Chunks"). Decoders check everything that can be checked without the rest of the file,
/// given the features the file names; their errors describe the fault and have no `where`.
namespace t4d::formats {

/// How arrays are stored.
struct ArrayOptions {
  int level = 3;         ///< zstd level; 0 for none
  bool float32 = false;  ///< store positions as float32
};

t4d_layout::ByteWriter encodeConnectivity(const model::Connectivity& connectivity,
                                          const ArrayOptions& options);
Result<std::shared_ptr<const model::Connectivity>> decodeConnectivity(
    std::span<const std::byte> payload, t4d_layout::Features features = {});

t4d_layout::ByteWriter encodeLayer(double time, std::span<const model::Point4> vertices,
                                   const ArrayOptions& options);

/// Vertices at one time, as stored.
struct Layer {
  double time = 0;
  PackedArray positions;  ///< points into the payload

  std::uint64_t size() const { return positions.rows; }
};
Result<Layer> decodeLayer(std::span<const std::byte> payload, t4d_layout::Features features = {});

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

/// A slab without the parts it shares with others.
struct SlabChunk {
  model::TimeSpan time;
  SlabParts parts;
  std::vector<model::Point4> interior;  ///< the interior vertices that are not means
  std::vector<model::Attribute> attributes;
};

t4d_layout::ByteWriter encodeSlab(const model::TimeSpan& time, const SlabParts& parts,
                                  std::span<const model::Point4> interior,
                                  std::span<const model::Attribute> attributes,
                                  const ArrayOptions& options);
Result<SlabChunk> decodeSlab(std::span<const std::byte> payload,
                             t4d_layout::Features features = {});

/// Adds a slab to the summary of its body. With `float32` its positions are stored as floats.
void addSlab(BodySummary& body, const model::Slab& slab, bool float32 = false);

/// Checks the summary in the file against the slabs actually found. Slab count and times are left
/// to checkDone, which does not need the slabs.
Result<void> checkSummary(const BodySummary& said, const BodySummary& found);

/// The end mark, after all chunks that hold data.
struct Done {
  std::uint64_t chunks = 0;  ///< before this one
  std::vector<BodySummary> bodies;
};

t4d_layout::ByteWriter encodeDone(const Done& done);
Result<Done> decodeDone(std::span<const std::byte> payload);

/// The location of one slab, in file order.
struct IndexRecord {
  std::uint64_t slab = 0;       ///< offset of the slab's chunk
  std::uint64_t slabBytes = 0;  ///< size of the chunk, including header and padding
  SlabParts parts;
  model::TimeSpan time;

  friend bool operator==(const IndexRecord& a, const IndexRecord& b) {
    return a.slab == b.slab && a.slabBytes == b.slabBytes && a.parts == b.parts &&
           a.time.begin == b.time.begin && a.time.end == b.time.end;
  }
};

t4d_layout::ByteWriter encodeIndex(std::span<const IndexRecord> records);
Result<std::vector<IndexRecord>> decodeIndex(std::span<const std::byte> payload);

/// Checks that the attributes of a slab, those of its connectivity and its own, can be stored:
/// names are UTF-8 and not too long, names are unique within a domain, rows fit.
Result<void> checkStorable(std::span<const model::Attribute> ofConnectivity,
                           std::span<const model::Attribute> ofSlab);

}  // namespace t4d::formats
