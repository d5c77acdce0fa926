#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Where the layer is now that began `distance` bytes before the POSE at `pose` when the file was
/// written; empty if it is lost.
using LayerOfPose =
    std::function<std::optional<std::uint64_t>(std::uint64_t pose, std::uint64_t distance)>;

/// Slabs of one body, assembled from their chunks. Parts shared by two slabs that are read in a row
/// are read once.
class SlabSource : public model::Source {
 public:
  /// `file` must outlive this object. In a file that has lost bytes, records have the parts where
  /// they are now, and `layerOf` finds the layers of poses.
  SlabSource(const ChunkFile& file, const t4d_layout::Features& features, LayerOfPose layerOf = {})
      : file_(&file),
        features_(features),
        layerOf_(std::move(layerOf)),
        kept_(std::make_unique<Kept>()) {}

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
  /// The LAYR of posed layers.
  struct Reference {
    std::uint64_t offset = 0;
    std::shared_ptr<const std::vector<model::Point3>> points;
    std::vector<model::Attribute> attributes;
    bool float32 = false;
  };
  /// A layer as stored: a LAYR, or a POSE; no vertices if there is none.
  struct StoredLayer {
    std::uint64_t offset = 0;
    Payload payload;
    Layer layer;  // time and attributes; positions of a LAYR, which point into `payload`
    std::shared_ptr<const model::LayerPose> pose;

    std::uint64_t size() const { return pose ? pose->reference->size() : layer.size(); }
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
    std::optional<Reference> reference;
  };

  /// Tells the file which chunks a slab has. Where slabs are read in order, those that follow are
  /// told as well: a remote file comes in larger pieces then.
  void plan(std::size_t index) const;
  Result<std::shared_ptr<const model::Slab>> readSlab(const IndexRecord& record) const;
  Result<ConnectivityPointer> readConnectivity(std::uint64_t offset) const;
  Result<StoredLayer> readLayer(std::uint64_t offset) const;
  Result<Reference> readReference(std::uint64_t offset) const;
  /// `into` has the layer's size.
  Result<void> unpack(const StoredLayer& stored, std::span<model::Point4> into) const;
  /// How a layer of these vertices, the last that was read, has been made, if that can be told.
  std::shared_ptr<const model::LayerPose> poseOf(const StoredLayer& stored,
                                                 std::span<const model::Point4> vertices) const;
  /// The layer at `offset` if it is kept; the cache then gives it up.
  std::optional<DecodedLayer> takeKeptLayer(std::uint64_t offset) const;

  const ChunkFile* file_;
  t4d_layout::Features features_;
  LayerOfPose layerOf_;
  std::vector<IndexRecord> records_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace t4d::formats
