#pragma once

#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Where the parts of a slab are: where the slab says, or, in a file that has lost bytes, where its
/// record says.
enum class PartsAt : std::uint8_t { Slab, Record };

/// Slabs of one body, put together from their chunks one at a time. What two slabs in a row share
/// is read once.
class SlabSource : public model::Source {
 public:
  /// `file` lives as long as this.
  SlabSource(ChunkFile& file, t4d_layout::Features features, PartsAt partsAt = PartsAt::Slab)
      : file_(&file), features_(features), partsAt_(partsAt) {}

  void add(const IndexRecord& record) { records_.push_back(record); }
  const IndexRecord& record(std::size_t index) const { return records_[index]; }

  std::size_t slabCount() const override { return records_.size(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return records_[index].time; }
  /// Errors name the slab by its number in the body.
  Result<const model::Slab*> slab(std::size_t index) override;

  /// Any slab of the file, added or not. It is judged by all that can be said of one slab; it stays
  /// valid until the next call. Errors have the offset of the chunk that is wrong.
  Result<const model::Slab*> read(const IndexRecord& record);

 private:
  struct StoredLayer {
    std::vector<std::byte> payload;
    Layer layer;  // in `payload`; of no vertices where there is no layer
  };

  Result<void> readSlab(const IndexRecord& record);
  Result<void> readConnectivity(std::uint64_t offset);
  Result<StoredLayer> readLayer(std::uint64_t offset);

  ChunkFile* file_;
  t4d_layout::Features features_;
  PartsAt partsAt_;
  std::vector<IndexRecord> records_;
  model::Slab slab_;
  std::optional<std::uint64_t> connectivityOffset_;  // of the connectivity in `slab_`
  std::uint64_t upperOffset_ = 0;                    // the layer that `upper_` is
  Layer upper_;
};

}  // namespace t4d::formats
