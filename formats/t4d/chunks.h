#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/chunk_fields.h"
#include "formats/t4d/layout.h"
#include "t4d/error.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

/// The contents of the chunks of a .t4d file but HEAD and INDX, with encoder and decoder side by
/// side (SPEC.md, section "Chunks"). Decoders check everything that can be checked without the rest
/// of the file, given the features the file names; their errors describe the fault and have no
/// `where`. Payloads are given without the table of their blocks.
namespace t4d::formats {

t4d_layout::PayloadWriter encodeConnectivity(const model::Connectivity& connectivity,
                                             const ArrayOptions& options);

/// The connectivity of a slab that is made piece by piece, and the bounds of each block of cells if
/// there are several, which belong into SLAB.
struct StreamedConnectivity {
  t4d_layout::PayloadWriter payload;
  std::vector<model::Bounds4> bounds;
};
/// Makes each block of cells once. Fails if checkCells does.
Result<StreamedConnectivity> encodeConnectivity(const model::StreamedSlab& slab, int level);
Result<std::shared_ptr<const model::Connectivity>> decodeConnectivity(
    const t4d_layout::PayloadView& payload, const t4d_layout::Features& features = {});

/// `attributes` have a row for each of the vertices.
t4d_layout::PayloadWriter encodeLayer(double time, std::span<const model::Point4> vertices,
                                      std::span<const model::Attribute> attributes,
                                      const ArrayOptions& options);
t4d_layout::PayloadWriter encodeLayer(double time, std::uint64_t count, const VertexMaker& vertices,
                                      const ArrayOptions& options);

/// Vertices at one time, as stored.
struct Layer {
  double time = 0;
  PackedArray positions;  ///< points into the payload
  std::vector<model::Attribute> attributes;

  std::uint64_t size() const { return positions.rows; }
};
Result<Layer> decodeLayer(const t4d_layout::PayloadView& payload,
                          const t4d_layout::Features& features = {});

/// Writes the vertices of a layer to `into`, which must have the layer's size.
Result<void> unpackLayer(const Layer& layer, std::span<model::Point4> into,
                         const t4d_layout::Features& features = {});

/// A layer that is another one, moved.
struct PosedLayer {
  double time = 0;
  std::uint64_t layer = 0;  ///< how many bytes before the POSE that one begins
  model::Affine3x4 pose = model::Affine3x4::Identity();
};
t4d_layout::PayloadWriter encodePose(const PosedLayer& posed);
Result<PosedLayer> decodePose(const t4d_layout::PayloadView& payload,
                              const t4d_layout::Features& features = {});

/// The distances in bytes from the slab back to its parts; 0 for a layer without vertices.
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

BlockRanges rangesOf(std::span<const model::Cell> cells, const model::VertexCounts& counts);

/// The ranges of each block of cells; empty if there is at most one block.
std::vector<BlockRanges> rangesOfBlocks(const model::Connectivity& connectivity);

/// The vertex with the position that a file stored this way gives back, in the range of the grid if
/// there is one.
model::Point4 roundedPoint(const model::Point4& vertex, const ArrayOptions& options);

/// The slab as it is read back: its positions are rounded, and its means computed from those.
model::Slab roundedSlab(const model::Slab& slab, const ArrayOptions& options);

/// The bounds of the vertices of each block of cells; empty if there is at most one block.
std::vector<model::Bounds4> boundsOfBlocks(const model::Connectivity& connectivity,
                                           std::span<const model::Point4> vertices);

/// What the fronts of CONN, LAYR and SLAB say, read as far as the arrays that are needed to read a
/// slab by blocks; their other arrays follow.
struct ConnectivityFront {
  model::VertexCounts counts;
  std::uint32_t means = 0;
  std::uint32_t attributes = 0;
  std::vector<BlockRanges> ranges;
  PackedArray cells;
};
Result<ConnectivityFront> takeConnectivityFront(t4d_layout::PayloadReader& from,
                                                const t4d_layout::Features& features);
struct LayerFront {
  double time = 0;
  std::uint32_t attributes = 0;
  PackedArray positions;
};
Result<LayerFront> takeLayerFront(t4d_layout::PayloadReader& from,
                                  const t4d_layout::Features& features);
struct SlabFront {
  model::TimeSpan time;
  SlabParts parts;
  std::uint32_t attributes = 0;
  std::vector<model::Bounds4> cellBounds;  ///< as boundsOfBlocks gives them, or none
  PackedArray positions;
  PackedArray times;
};
Result<SlabFront> takeSlabFront(t4d_layout::PayloadReader& from,
                                const t4d_layout::Features& features);

/// A slab without the parts it shares with others.
struct SlabChunk {
  model::TimeSpan time;
  SlabParts parts;
  std::vector<model::Bounds4> cellBounds;  ///< as boundsOfBlocks gives them, or none
  std::vector<model::Point4> interior;     ///< the interior vertices that are not means
  /// The attributes as they are stored: those of vertices have a row for each of `interior`.
  std::vector<model::Attribute> attributes;
};

/// The attributes that the chunk of a slab has: of vertices, rows of the interior vertices that are
/// not means, if there are any; then those of cells.
std::vector<model::Attribute> ownAttributes(const model::Slab& slab);

/// The contents of the chunk of a slab after its time and its parts.
struct SlabContents {
  std::uint32_t attributes = 0;  ///< their number
  /// All after it; begins at a multiple of 8 bytes, which arrays are aligned to.
  t4d_layout::PayloadWriter payload;
};

/// `slab` is as it is stored: rounded with float32 or a grid.
SlabContents encodeContents(const model::Slab& slab, const ArrayOptions& options);
/// `bounds` are those of StreamedConnectivity.
SlabContents encodeContents(const model::StreamedSlab& slab, std::span<const model::Bounds4> bounds,
                            const ArrayOptions& options);
t4d_layout::PayloadWriter encodeSlab(const model::TimeSpan& time, const SlabParts& parts,
                                     SlabContents contents);
/// Encodes a whole slab in memory.
t4d_layout::PayloadWriter encodeSlab(const model::Slab& slab, const SlabParts& parts,
                                     const ArrayOptions& options);
Result<SlabChunk> decodeSlab(const t4d_layout::PayloadView& payload,
                             const t4d_layout::Features& features = {});

/// Adds a slab, as it is stored, to the summary of its body.
void addSlab(BodySummary& body, const model::Slab& slab);
void addSlab(BodySummary& body, const model::TimeSpan& time, const model::VertexCounts& counts,
             std::uint64_t cells, const model::Bounds3& bounds);

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

/// Checks that the attributes of a slab, those of its connectivity and its own, can be stored:
/// names are UTF-8 and not too long, names are unique within a domain, rows fit.
Result<void> checkStorable(std::span<const model::Attribute> ofConnectivity,
                           std::span<const model::Attribute> ofSlab);

}  // namespace t4d::formats
