#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Where to find the parts of a slab: at the offsets in the slab or, in a file that has lost bytes,
/// at those in its record.
enum class PartsAt : std::uint8_t { Slab, Record };

/// Slabs of one body, assembled from their chunks. Parts shared by two slabs that are read in a row
/// are read once.
class SlabSource : public model::Source {
 public:
  /// `file` must outlive this object.
  SlabSource(const ChunkFile& file, t4d_layout::Features features, PartsAt partsAt = PartsAt::Slab)
      : file_(&file), features_(features), partsAt_(partsAt), kept_(std::make_unique<Kept>()) {}

  void add(const IndexRecord& record) { records_.push_back(record); }
  const IndexRecord& record(std::size_t index) const { return records_[index]; }

  std::size_t slabCount() const override { return records_.size(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return records_[index].time; }
  std::optional<model::Bounds3> bounds(std::size_t index) const override {
    const auto& extent = records_[index].extent;
    return extent ? std::optional(extent->bounds) : std::nullopt;
  }
  /// Errors name the slab by its number in the body.
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;

  /// Slabs of several blocks of cells without means and attributes, if the file has an index.
  Result<std::shared_ptr<const model::SlabBlocks>> blocks(std::size_t index) const override;

  /// Any slab of the file, added or not, checked as far as a single slab can be. Errors give the
  /// offset of the faulty chunk.
  Result<std::shared_ptr<const model::Slab>> read(const IndexRecord& record) const;

 private:
  struct StoredLayer {
    Payload payload;
    Layer layer;  // points into `payload`; no vertices if there is no layer
  };
  struct DecodedLayer {
    std::vector<model::Point4> vertices;
    std::vector<model::Attribute> attributes;
  };

  using ConnectivityPointer = std::shared_ptr<const model::Connectivity>;

  /// Parts of the last slab read, which the next one is likely to share.
  struct Kept {
    std::mutex mutex;
    std::optional<std::uint64_t> connectivityOffset;
    ConnectivityPointer connectivity;
    std::uint64_t upperOffset = 0;
    DecodedLayer upperLayer;
    std::optional<std::size_t> index;  // of the slab planned last
  };

  /// Tells the file which chunks a slab has. Where slabs are read in order, those that follow are
  /// told as well: a remote file comes in larger pieces then.
  void plan(std::size_t index) const;
  Result<std::shared_ptr<const model::Slab>> readSlab(const IndexRecord& record) const;
  Result<ConnectivityPointer> readConnectivity(std::uint64_t offset) const;
  Result<StoredLayer> readLayer(std::uint64_t offset) const;
  /// The layer at `offset` if it is kept; the cache then gives it up.
  std::optional<DecodedLayer> takeKeptLayer(std::uint64_t offset) const;

  const ChunkFile* file_;
  t4d_layout::Features features_;
  PartsAt partsAt_;
  std::vector<IndexRecord> records_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace t4d::formats
