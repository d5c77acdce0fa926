#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/index_chunk.h"
#include "model/layered_slab.h"
#include "model/shared_parts.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Where the layer is now that began `distance` bytes before the POSE at `pose` when the file was
/// written; empty if it is lost.
using LayerOfPose =
    std::function<std::optional<std::uint64_t>(std::uint64_t pose, std::uint64_t distance)>;

/// Slabs of one body, assembled from their chunks. Parts shared by slabs that are read in a row, or
/// at the same time, are read once.
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
  std::optional<std::uint64_t> cellCount(std::size_t index) const override {
    const auto& extent = records_[index].extent;
    return extent ? std::optional(extent->cells) : std::nullopt;
  }
  /// Errors name the slab by its number in the body.
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;

  /// Slabs of several blocks of cells without means and attributes, if the file has an index.
  Result<std::shared_ptr<const model::SlabBlocks>> blocks(std::size_t index) const override;

  /// Slabs with means and without attributes of vertices.
  Result<std::shared_ptr<const model::LayeredSlab>> layered(std::size_t index) const override;

  /// Any slab of the file, added or not, checked as far as a single slab can be. Errors give the
  /// offset of the faulty chunk.
  Result<std::shared_ptr<const model::Slab>> read(const IndexRecord& record) const;

 private:
  /// The LAYR of posed layers.
  struct Reference {
    std::shared_ptr<const std::vector<model::Point3>> points;
    std::vector<model::Attribute> attributes;
    bool float32 = false;
  };
  /// The layer of a LAYR or a POSE; no vertices if there is none.
  struct DecodedLayer {
    std::vector<model::Point4> vertices;
    std::vector<model::Attribute> attributes;
    /// The pose that made it, if that can be told.
    std::shared_ptr<const model::LayerPose> pose;
  };

  using ConnectivityPointer = std::shared_ptr<const model::Connectivity>;
  using LayerPointer = std::shared_ptr<const DecodedLayer>;
  using ReferencePointer = std::shared_ptr<const Reference>;

  /// Parts that slabs which are read in a row, or at the same time, are likely to share.
  struct Kept {
    model::SharedParts<std::uint64_t, ConnectivityPointer> connectivities;
    model::SharedParts<std::uint64_t, DecodedLayer> layers;
    model::SharedParts<std::uint64_t, Reference> references;
    std::mutex mutex;
    std::optional<std::size_t> index;  // of the slab planned last
  };

  /// Tells the file which chunks a slab has. Where slabs are read in order, those that follow are
  /// told as well: a remote file comes in larger pieces then.
  void plan(std::size_t index) const;
  /// The parts that a slab is assembled from.
  struct Parts {
    SlabChunk own;
    ConnectivityPointer connectivity;
    LayerPointer lower;
    LayerPointer upper;
  };
  /// Fails where they do not fit together.
  Result<Parts> readParts(const IndexRecord& record) const;
  Result<std::shared_ptr<const model::Slab>> readSlab(const IndexRecord& record) const;
  Result<std::shared_ptr<const model::LayeredSlab>> readLayered(const IndexRecord& record) const;
  Result<ConnectivityPointer> connectivity(std::uint64_t offset) const;
  Result<LayerPointer> layer(std::uint64_t offset) const;
  Result<DecodedLayer> readLayer(std::uint64_t offset) const;
  Result<DecodedLayer> readPose(const ChunkHeader& header, const Payload& payload) const;
  Result<ReferencePointer> reference(std::uint64_t offset) const;
  Result<Reference> readReference(std::uint64_t offset) const;

  const ChunkFile* file_;
  t4d_layout::Features features_;
  LayerOfPose layerOf_;
  std::vector<IndexRecord> records_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace t4d::formats
