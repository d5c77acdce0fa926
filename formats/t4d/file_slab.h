#pragma once

#include <array>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/index_chunk.h"
#include "model/slab_blocks.h"

namespace t4d::formats {

/// A slab of a file, of which blocks are read when they are needed: the front of each of its chunks
/// says what is in them.
class FileSlab : public model::SlabBlocks {
 public:
  /// Null for a slab that is better read whole: with one block of cells, with means, with a
  /// layer that is a pose, or with attributes. The file must outlive the slab.
  static Result<std::shared_ptr<const FileSlab>> open(const ChunkFile& file,
                                                      const IndexRecord& record,
                                                      const t4d_layout::Features& features);

  ~FileSlab() override;

  std::size_t blockCount() const override { return slab_.cellBounds.size(); }
  const model::Bounds4& bounds(std::size_t block) const override { return slab_.cellBounds[block]; }
  Result<model::CellBlock> read(std::size_t block) const override;

 private:
  /// Positions, and times if they are stored, of the lower layer, the interior or the upper layer.
  struct Part {
    const PartialPayload* payload = nullptr;  // null for an empty layer
    PackedArray positions;
    std::optional<PackedArray> times;
    double time = 0;  // if they are not
    std::uint64_t offset = 0;
  };
  using Vertices = std::shared_ptr<const std::vector<model::Point4>>;
  /// Blocks of vertices that were unpacked last.
  struct Cache;

  FileSlab(const ChunkFile& file, const IndexRecord& record, const t4d_layout::Features& features);

  Result<bool> openParts();
  Result<void> checkParts() const;
  Result<Vertices> unpackVertices(std::size_t part, std::size_t block) const;
  Result<Vertices> vertices(std::size_t part, std::size_t block) const;
  std::uint32_t firstOf(std::size_t part) const;

  const ChunkFile* file_;
  IndexRecord record_;
  t4d_layout::Features features_;
  PartialPayload connectivityPayload_;
  PartialPayload slabPayload_;
  std::array<PartialPayload, 2> layerPayloads_;  // lower, upper
  ConnectivityFront connectivity_;
  SlabFront slab_;
  std::array<Part, 3> parts_;  // lower, interior, upper
  std::unique_ptr<Cache> cache_;
};

}  // namespace t4d::formats
