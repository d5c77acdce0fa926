#include "t4d/formats/t4d/slab_source.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/formats/t4d/within_memory.h"

namespace t4d::formats {

using namespace t4d_layout;
using model::Connectivity;

Result<const model::Slab*> SlabSource::slab(std::size_t index) {
  auto slab = read(records_[index]);
  if (!slab) {
    Error error = slab.error();
    error.message = fmt::format("slab {}: {}", index, error.message);
    return pass(std::move(error));
  }
  return slab;
}

Result<const model::Slab*> SlabSource::read(const IndexRecord& record) {
  if (auto read = withinMemory(file_->path(), [&] { return readSlab(record); }); !read) {
    return pass(read.error());
  }
  return &slab_;
}

Result<void> SlabSource::readConnectivity(std::uint64_t offset) {
  if (connectivityOffset_ == offset) return {};
  connectivityOffset_.reset();
  auto chunk = file_->readChunk(offset, kConnectivity);
  if (!chunk) return pass(chunk.error());
  auto connectivity = decodeConnectivity(chunk->payload, features_);
  if (!connectivity) return file_->damaged(offset, "CONN: " + connectivity.error().message);
  slab_.connectivity = std::move(*connectivity);
  connectivityOffset_ = offset;
  return {};
}

Result<SlabSource::StoredLayer> SlabSource::readLayer(std::uint64_t offset) {
  StoredLayer stored;
  if (offset == 0) return stored;
  auto chunk = file_->readChunk(offset, kLayer);
  if (!chunk) return pass(chunk.error());
  stored.payload = std::move(chunk->payload);
  auto layer = decodeLayer(stored.payload, features_);
  if (!layer) return file_->damaged(offset, "LAYR: " + layer.error().message);
  stored.layer = *layer;
  return stored;
}

Result<void> SlabSource::readSlab(const IndexRecord& record) {
  ChunkFile& file = *file_;
  auto chunk = file.readChunk(record.slab, kSlab);
  if (!chunk) return pass(chunk.error());
  const auto wrong = [&](const std::string& message) {
    return file.damaged(record.slab, "SLAB: " + message);
  };
  auto decoded = decodeSlab(chunk->payload, features_);
  if (!decoded) return wrong(decoded.error().message);
  if (partsAt_ == PartsAt::Record) decoded->parts = record.parts;
  if (!(record == IndexRecord{record.slab, chunk->header.bytes(), decoded->parts, decoded->time})) {
    return wrong("the index says something else than the slab itself");
  }
  std::vector<model::Point4> kept;  // the layer below, where the slab before ended with it
  const bool isKept = record.parts.lower != 0 && record.parts.lower == upperOffset_;
  if (isKept) kept.assign(slab_.upperLayer().begin(), slab_.upperLayer().end());
  upperOffset_ = 0;
  if (auto read = readConnectivity(record.parts.connectivity); !read) return read;
  const Connectivity& connectivity = *slab_.connectivity;

  auto lower = readLayer(isKept ? 0 : record.parts.lower);
  if (!lower) return pass(lower.error());
  auto upper = readLayer(record.parts.upper);
  if (!upper) return pass(upper.error());
  const std::uint64_t lowerCount = isKept ? kept.size() : lower->layer.size();
  const std::uint64_t interiorCount = connectivity.firstMean() - connectivity.lowerCount;
  if (lowerCount != connectivity.lowerCount || upper->layer.size() != connectivity.upperCount ||
      decoded->interior.size() != interiorCount) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, "
                    "the file {}, {} and {}",
                    connectivity.lowerCount, interiorCount, connectivity.upperCount, lowerCount,
                    decoded->interior.size(), upper->layer.size()));
  }
  // Those of the slab itself: the index may say -0 where it says 0.
  slab_.timeBegin = decoded->time.begin;
  slab_.timeEnd = decoded->time.end;
  if (slab_.vertices.capacity() < connectivity.vertexCount) {
    slab_.vertices = std::vector<model::Point4>();  // not those of two slabs at a time
  }
  slab_.vertices.resize(connectivity.vertexCount);
  const std::span vertices(slab_.vertices);
  if (isKept) {
    std::copy(kept.begin(), kept.end(), vertices.begin());
    kept = std::vector<model::Point4>();
  } else if (auto set = unpackLayer(lower->layer, vertices.first(lowerCount)); !set) {
    return file.damaged(record.parts.lower, "LAYR: " + set.error().message);
  }
  std::copy(decoded->interior.begin(), decoded->interior.end(), vertices.begin() + lowerCount);
  if (auto set = unpackLayer(upper->layer, vertices.last(connectivity.upperCount)); !set) {
    return file.damaged(record.parts.upper, "LAYR: " + set.error().message);
  }
  setMeans(connectivity, slab_.vertices);
  slab_.attributes = std::move(decoded->attributes);
  if (auto sound = checkSlab(slab_); !sound) return wrong(sound.error().message);
  if (auto sound = checkStorable(connectivity.cellAttributes, slab_.attributes); !sound) {
    return wrong(sound.error().message);
  }
  upperOffset_ = record.parts.upper;
  return {};
}

}  // namespace t4d::formats
