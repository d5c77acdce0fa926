#include "t4d/formats/t4d/slab_source.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "t4d/formats/t4d/file_slab.h"
#include "t4d/formats/t4d/vertex_attributes.h"
#include "t4d/formats/t4d/within_memory.h"

namespace t4d::formats {

using namespace t4d_layout;
using model::Connectivity;

namespace {

std::shared_ptr<const std::vector<model::Point3>> positionsOf(
    std::span<const model::Point4> vertices) {
  auto positions = std::make_shared<std::vector<model::Point3>>();
  positions->reserve(vertices.size());
  for (const model::Point4& vertex : vertices) positions->push_back(vertex.head<3>());
  return positions;
}

}  // namespace

Result<std::shared_ptr<const model::Slab>> SlabSource::slab(std::size_t index) const {
  if (file_->remote()) plan(index);
  auto slab = read(records_[index]);
  if (!slab) {
    Error error = slab.error();
    error.message = fmt::format("slab {}: {}", index, error.message);
    return pass(std::move(error));
  }
  return slab;
}

Result<std::shared_ptr<const model::SlabBlocks>> SlabSource::blocks(std::size_t index) const {
  if (layerOf_) return std::shared_ptr<const model::SlabBlocks>();
  {
    // FileSlab would read the front of the connectivity to find this out.
    const std::scoped_lock lock(kept_->mutex);
    if (kept_->connectivityOffset == records_[index].connectivity() &&
        (kept_->connectivity->means.size() > 0 || !kept_->connectivity->cellAttributes.empty())) {
      return std::shared_ptr<const model::SlabBlocks>();
    }
  }
  if (file_->remote()) plan(index);
  auto slab = withinMemory(file_->path(),
                           [&] { return FileSlab::open(*file_, records_[index], features_); });
  if (!slab) return pass(slab.error());
  return std::shared_ptr<const model::SlabBlocks>(std::move(*slab));
}

void SlabSource::plan(std::size_t index) const {
  constexpr std::uint64_t kAhead = std::uint64_t{4} << 20;
  const std::scoped_lock lock(kept_->mutex);
  if (kept_->index == index) return;
  // Threads come a little out of order, and slabs may be left out.
  constexpr std::size_t kNear = 16;
  const std::size_t last = kept_->index.value_or(index + kNear + 1);
  const bool inOrder = std::max(index, last) - std::min(index, last) <= kNear;
  kept_->index = index;
  const auto length = [](const ByteRange& range) { return range.end - range.begin; };
  std::vector<ByteRange> ranges;
  std::uint64_t bytes = 0;
  std::uint64_t connectivity = 0;
  const std::size_t end = inOrder ? records_.size() : index + 1;
  for (std::size_t i = index; i < end && bytes < kAhead; ++i) {
    const IndexRecord& record = records_[i];
    if (record.connectivity() != connectivity) {
      connectivity = record.connectivity();
      ranges.push_back(file_->placeOf(connectivity));
      bytes += length(ranges.back());
    }
    ByteRange all = file_->placeOf(record.slab);
    std::uint64_t own = length(all);
    for (const std::uint64_t layer : {record.lower(), record.upper()}) {
      if (layer == 0) continue;
      const ByteRange range = file_->placeOf(layer);
      ranges.push_back(range);
      own += length(range);
      all = {std::min(all.begin, range.begin), std::max(all.end, range.end)};
    }
    // The slab before may stand between the lower layer and the others.
    ranges.push_back(length(all) <= 2 * own ? all : file_->placeOf(record.slab));
    bytes += own;
  }
  file_->plan(ranges);
}

Result<std::shared_ptr<const model::Slab>> SlabSource::read(const IndexRecord& record) const {
  return withinMemory(file_->path(), [&] { return readSlab(record); });
}

Result<SlabSource::ConnectivityPointer> SlabSource::readConnectivity(std::uint64_t offset) const {
  {
    const std::scoped_lock lock(kept_->mutex);
    if (kept_->connectivityOffset == offset) return kept_->connectivity;
    // Avoids two in memory while this one is decoded.
    kept_->connectivityOffset.reset();
    kept_->connectivity.reset();
  }
  auto chunk = file_->readChunk(offset, kConnectivity);
  if (!chunk) return pass(chunk.error());
  auto connectivity = decodeConnectivity(chunk->payload.view, features_);
  if (!connectivity) return file_->damaged(offset, "CONN: " + connectivity.error().message);
  const std::scoped_lock lock(kept_->mutex);
  // Another thread may have been faster: slabs that repeat a connectivity share one object.
  if (kept_->connectivityOffset == offset) return kept_->connectivity;
  kept_->connectivityOffset = offset;
  kept_->connectivity = *connectivity;
  return connectivity;
}

std::optional<SlabSource::DecodedLayer> SlabSource::takeKeptLayer(std::uint64_t offset) const {
  const std::scoped_lock lock(kept_->mutex);
  if (offset == 0 || offset != kept_->upperOffset) return std::nullopt;
  kept_->upperOffset = 0;
  return std::exchange(kept_->upperLayer, {});
}

Result<SlabSource::StoredLayer> SlabSource::readLayer(std::uint64_t offset) const {
  StoredLayer stored;
  if (offset == 0) return stored;
  stored.offset = offset;
  const auto header = file_->readChunkHeader(offset);
  if (!header) return pass(header.error());
  if (header->type != kLayer && header->type != kPose) {
    return file_->damaged(
        offset, fmt::format("a chunk {} is here, where a layer is expected", header->name()));
  }
  auto payload = file_->readPayload(*header);
  if (!payload) return pass(payload.error());
  const auto wrong = [&](const std::string& message) {
    return file_->damaged(offset, fmt::format("{}: {}", header->name(), message));
  };
  stored.payload = std::move(*payload);
  if (header->type == kLayer) {
    auto layer = decodeLayer(stored.payload.view, features_);
    if (!layer) return wrong(layer.error().message);
    stored.layer = std::move(*layer);
    return stored;
  }
  const auto posed = decodePose(stored.payload.view, features_);
  if (!posed) return wrong(posed.error().message);
  std::optional<std::uint64_t> place = offset - posed->layer;
  if (layerOf_) {
    place = layerOf_(offset, posed->layer);
    if (!place) {
      return wrong(
          fmt::format("its LAYR, {} bytes before it, is missing or damaged", posed->layer));
    }
  } else if (posed->layer == 0 || posed->layer >= offset) {
    return wrong("it moves no LAYR that comes before it");
  }
  auto reference = readReference(*place);
  if (!reference) return pass(reference.error());
  stored.layer.time = posed->time;
  stored.layer.attributes = std::move(reference->attributes);
  stored.pose = std::make_shared<const model::LayerPose>(
      model::LayerPose{std::move(reference->points), posed->pose, reference->float32});
  return stored;
}

Result<SlabSource::Reference> SlabSource::readReference(std::uint64_t offset) const {
  {
    const std::scoped_lock lock(kept_->mutex);
    if (kept_->reference && kept_->reference->offset == offset) return *kept_->reference;
  }
  auto chunk = file_->readChunk(offset, kLayer);
  if (!chunk) return pass(chunk.error());
  auto layer = decodeLayer(chunk->payload.view, features_);
  if (!layer) return file_->damaged(offset, "LAYR: " + layer.error().message);
  std::vector<model::Point4> vertices(layer->size());
  if (auto set = unpackLayer(*layer, vertices, features_); !set) {
    return file_->damaged(offset, "LAYR: " + set.error().message);
  }
  Reference reference{offset, positionsOf(vertices), std::move(layer->attributes),
                      layer->positions.type == model::ScalarType::Float32};
  const std::scoped_lock lock(kept_->mutex);
  // Another thread may have been faster: layers of one reference share one object.
  if (!kept_->reference || kept_->reference->offset != offset) kept_->reference = reference;
  return *kept_->reference;
}

Result<void> SlabSource::unpack(const StoredLayer& stored, std::span<model::Point4> into) const {
  if (!stored.pose) {
    auto set = unpackLayer(stored.layer, into, features_);
    if (!set) return file_->damaged(stored.offset, "LAYR: " + set.error().message);
    return {};
  }
  for (std::size_t i = 0; i < into.size(); ++i) {
    into[i] << stored.pose->at(i), stored.layer.time;
  }
  return {};
}

std::shared_ptr<const model::LayerPose> SlabSource::poseOf(
    const StoredLayer& stored, std::span<const model::Point4> vertices) const {
  if (stored.pose || !features_.pose || vertices.empty()) return stored.pose;
  // A LAYR of this file may be what the next layers are poses of.
  const bool float32 = stored.layer.positions.type == model::ScalarType::Float32;
  const std::scoped_lock lock(kept_->mutex);
  if (!kept_->reference || kept_->reference->offset != stored.offset) {
    kept_->reference = {stored.offset, positionsOf(vertices), stored.layer.attributes, float32};
  }
  return std::make_shared<const model::LayerPose>(model::LayerPose{
      kept_->reference->points, model::Affine3x4::Identity(), kept_->reference->float32});
}

Result<std::shared_ptr<const model::Slab>> SlabSource::readSlab(const IndexRecord& record) const {
  const ChunkFile& file = *file_;
  auto chunk = file.readChunk(record.slab, kSlab);
  if (!chunk) return pass(chunk.error());
  const auto wrong = [&](const std::string& message) {
    return file.damaged(record.slab, "SLAB: " + message);
  };
  auto decoded = decodeSlab(chunk->payload.view, features_);
  if (!decoded) return wrong(decoded.error().message);
  if (layerOf_) decoded->parts = record.parts;
  if (!(record == IndexRecord{record.slab, chunk->header.bytes(), decoded->parts, decoded->time})) {
    return wrong("the index says something else than the slab itself");
  }
  auto kept = takeKeptLayer(record.lower());
  const auto slab = std::make_shared<model::Slab>();
  auto shared = readConnectivity(record.connectivity());
  if (!shared) return pass(shared.error());
  slab->connectivity = std::move(*shared);
  const Connectivity& connectivity = *slab->connectivity;

  auto lower = readLayer(kept ? 0 : record.lower());
  if (!lower) return pass(lower.error());
  auto upper = readLayer(record.upper());
  if (!upper) return pass(upper.error());
  const std::uint64_t lowerCount = kept ? kept->vertices.size() : lower->size();
  const std::uint64_t interiorCount = connectivity.firstMean() - connectivity.lowerCount;
  if (lowerCount != connectivity.lowerCount || upper->size() != connectivity.upperCount ||
      decoded->interior.size() != interiorCount) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, "
                    "the file {}, {} and {}",
                    connectivity.lowerCount, interiorCount, connectivity.upperCount, lowerCount,
                    decoded->interior.size(), upper->size()));
  }
  // Use the slab's own times: the index may have -0 where it has 0.
  slab->timeBegin = decoded->time.begin;
  slab->timeEnd = decoded->time.end;
  slab->vertices.resize(connectivity.vertexCount);
  const std::span vertices(slab->vertices);
  if (kept) {
    std::ranges::copy(kept->vertices, vertices.begin());
    lower->layer.attributes = std::move(kept->attributes);
    kept.reset();
  } else if (auto set = unpack(*lower, vertices.first(lowerCount)); !set) {
    return pass(set.error());
  }
  std::copy(decoded->interior.begin(), decoded->interior.end(), vertices.begin() + lowerCount);
  if (auto set = unpack(*upper, vertices.last(connectivity.upperCount)); !set) {
    return pass(set.error());
  }
  slab->upperPose = poseOf(*upper, slab->upperLayer());
  setMeans(connectivity, slab->vertices);
  auto attributes = joinedAttributes(
      connectivity,
      {std::move(lower->layer.attributes), vertexRows(decoded->attributes, 0, interiorCount),
       std::move(upper->layer.attributes)},
      kMaxExpansion * file.knownBytes());
  if (!attributes) return wrong(attributes.error().message);
  slab->attributes = std::move(*attributes);
  std::ranges::copy_if(
      decoded->attributes, std::back_inserter(slab->attributes),
      [](const model::Attribute& own) { return own.domain == model::Domain::Cell; });
  if (auto sound = checkSlab(*slab); !sound) return wrong(sound.error().message);
  const auto sameBounds = [](const model::Bounds4& a, const model::Bounds4& b) {
    return a.min == b.min && a.max == b.max;
  };
  if (!decoded->cellBounds.empty() &&
      !std::ranges::equal(decoded->cellBounds, boundsOfBlocks(connectivity, slab->vertices),
                          sameBounds)) {
    return wrong("the bounds of its blocks of cells are not those of their vertices");
  }
  if (record.extent && *record.extent != extentOf(*slab)) {
    return wrong("the index says other cells or bounds than the slab has");
  }
  if (auto sound = checkStorable(connectivity.cellAttributes, slab->attributes); !sound) {
    return wrong(sound.error().message);
  }
  const std::scoped_lock lock(kept_->mutex);
  kept_->upperOffset = record.upper();
  kept_->upperLayer = {
      {slab->upperLayer().begin(), slab->upperLayer().end()},
      vertexRows(slab->attributes, connectivity.firstUpper(), connectivity.upperCount)};
  return slab;
}

}  // namespace t4d::formats
