#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Where the parts of a slab are: where the slab says, or, in a file that has lost bytes, where its
/// record says.
enum class PartsAt : std::uint8_t { Slab, Record };

/// Slabs of one body, put together from their chunks. What two slabs that are read in a row share
/// is read once.
class SlabSource : public model::Source {
 public:
  /// `file` lives as long as this.
  SlabSource(const ChunkFile& file, t4d_layout::Features features, PartsAt partsAt = PartsAt::Slab)
      : file_(&file), features_(features), partsAt_(partsAt), kept_(std::make_unique<Kept>()) {}

  void add(const IndexRecord& record) { records_.push_back(record); }
  const IndexRecord& record(std::size_t index) const { return records_[index]; }

  std::size_t slabCount() const override { return records_.size(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return records_[index].time; }
  /// Errors name the slab by its number in the body.
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;

  /// Any slab of the file, added or not, judged by all that can be said of one slab. Errors have
  /// the offset of the chunk that is wrong.
  Result<std::shared_ptr<const model::Slab>> read(const IndexRecord& record) const;

 private:
  struct StoredLayer {
    std::vector<std::byte> payload;
    Layer layer;  // in `payload`; of no vertices where there is no layer
  };

  using ConnectivityPointer = std::shared_ptr<const model::Connectivity>;

  /// Of the slab that was read last: what the next one is likely to share.
  struct Kept {
    std::mutex mutex;
    std::optional<std::uint64_t> connectivityOffset;
    ConnectivityPointer connectivity;
    std::uint64_t upperOffset = 0;
    std::vector<model::Point4> upperLayer;
  };

  Result<std::shared_ptr<const model::Slab>> readSlab(const IndexRecord& record) const;
  Result<ConnectivityPointer> readConnectivity(std::uint64_t offset) const;
  Result<StoredLayer> readLayer(std::uint64_t offset) const;
  /// The layer at `offset` where it is kept, which it then no longer is.
  std::optional<std::vector<model::Point4>> takeKeptLayer(std::uint64_t offset) const;

  const ChunkFile* file_;
  t4d_layout::Features features_;
  PartsAt partsAt_;
  std::vector<IndexRecord> records_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace t4d::formats
