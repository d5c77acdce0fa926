#include "formats/t4d/slab_source.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/within_memory.h"

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

Result<Layer> SlabSource::readLayer(std::uint64_t offset) {
  if (offset == 0) return Layer{};
  auto chunk = file_->readChunk(offset, kLayer);
  if (!chunk) return pass(chunk.error());
  auto layer = decodeLayer(chunk->payload, features_);
  if (!layer) return file_->damaged(offset, "LAYR: " + layer.error().message);
  return layer;
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
  if (!(record == IndexRecord{record.slab, chunk->header.bytes(), decoded->parts, decoded->time})) {
    return wrong("the index says something else than the slab itself");
  }
  if (auto read = readConnectivity(record.parts.connectivity); !read) return read;
  const Connectivity& connectivity = *slab_.connectivity;

  Layer lower;
  if (record.parts.lower != 0 && record.parts.lower == upperOffset_) {
    lower = std::move(upper_);
  } else {
    auto read = readLayer(record.parts.lower);
    if (!read) return pass(read.error());
    lower = std::move(*read);
  }
  upperOffset_ = 0;
  auto upper = readLayer(record.parts.upper);
  if (!upper) return pass(upper.error());
  if (lower.vertices.size() != connectivity.lowerCount ||
      upper->vertices.size() != connectivity.upperCount ||
      decoded->interior.size() != connectivity.firstMean() - connectivity.lowerCount) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, the "
                    "file {}, {} and {}",
                    connectivity.lowerCount, connectivity.firstMean() - connectivity.lowerCount,
                    connectivity.upperCount, lower.vertices.size(), decoded->interior.size(),
                    upper->vertices.size()));
  }
  slab_.timeBegin = record.time.begin;
  slab_.timeEnd = record.time.end;
  slab_.vertices.resize(connectivity.vertexCount);
  auto at = std::copy(lower.vertices.begin(), lower.vertices.end(), slab_.vertices.begin());
  std::copy(decoded->interior.begin(), decoded->interior.end(), at);
  std::copy(upper->vertices.begin(), upper->vertices.end(),
            slab_.vertices.begin() + connectivity.firstUpper());
  setMeans(connectivity, slab_.vertices);
  slab_.attributes = std::move(decoded->attributes);
  if (auto sound = checkSlab(slab_); !sound) return wrong(sound.error().message);
  if (auto sound = checkStorable(connectivity.cellAttributes, slab_.attributes); !sound) {
    return wrong(sound.error().message);
  }
  upper_ = std::move(*upper);
  upperOffset_ = record.parts.upper;
  return {};
}

}  // namespace t4d::formats
