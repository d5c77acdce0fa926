#include "formats/t4d/slab_source.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "formats/t4d/file_slab.h"
#include "formats/t4d/vertex_attributes.h"
#include "formats/t4d/within_memory.h"

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

bool isOfCells(const model::Attribute& attribute) {
  return attribute.domain == model::Domain::Cell;
}

}  // namespace

Result<std::shared_ptr<const model::Slab>> SlabSource::slab(std::size_t index) const {
  if (file_->remote()) plan(index);
  auto slab = read(records_[index]);
  if (!slab) {
    Error error = slab.error();
    error.message = fmt::format("slab {}: {}", index, error.message);
    return error;
  }
  return slab;
}

Result<std::shared_ptr<const model::SlabBlocks>> SlabSource::blocks(std::size_t index) const {
  if (layerOf_) return std::shared_ptr<const model::SlabBlocks>();
  // FileSlab would read the front of the connectivity to find this out.
  if (const auto last = kept_->connectivities.last(records_[index].connectivity())) {
    if ((*last)->means.size() > 0 || !(*last)->cellAttributes.empty()) {
      return std::shared_ptr<const model::SlabBlocks>();
    }
  }
  if (file_->remote()) plan(index);
  auto slab = withinMemory(file_->path(),
                           [&] { return FileSlab::open(*file_, records_[index], features_); });
  if (!slab) return slab.error();
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
      ranges.push_back(file_->likelyLayerOf(layer));
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

Result<SlabSource::ConnectivityPointer> SlabSource::connectivity(std::uint64_t offset) const {
  const auto made = kept_->connectivities.get(offset, [&]() -> Result<ConnectivityPointer> {
    auto chunk = file_->readChunk(offset, kConnectivity);
    if (!chunk) return chunk.error();
    auto decoded = decodeConnectivity(chunk->payload.view, features_);
    if (!decoded) return file_->damaged(offset, "CONN: " + decoded.error().message);
    return decoded;
  });
  if (!made) return made.error();
  // It stays known while a slab has it, so that slabs which repeat it share one object.
  return ConnectivityPointer(*made, (*made)->get());
}

Result<SlabSource::LayerPointer> SlabSource::layer(std::uint64_t offset) const {
  if (offset == 0) return std::make_shared<const DecodedLayer>();
  return kept_->layers.get(offset, [&] { return readLayer(offset); });
}

Result<SlabSource::DecodedLayer> SlabSource::readLayer(std::uint64_t offset) const {
  const auto header = file_->readChunkHeader(offset);
  if (!header) return header.error();
  if (header->type != kLayer && header->type != kPose) {
    return file_->damaged(
        offset, fmt::format("a chunk {} is here, where a layer is expected", header->name()));
  }
  auto payload = file_->readPayload(*header);
  if (!payload) return payload.error();
  if (header->type == kPose) return readPose(*header, *payload);
  const auto wrong = [&](const Error& error) {
    return file_->damaged(offset, "LAYR: " + error.message);
  };
  auto stored = decodeLayer(payload->view, features_);
  if (!stored) return wrong(stored.error());
  DecodedLayer layer;
  layer.vertices.resize(stored->size());
  if (auto set = unpackLayer(*stored, layer.vertices, features_); !set) return wrong(set.error());
  layer.attributes = std::move(stored->attributes);
  if (!features_.pose || layer.vertices.empty()) return layer;
  // It may be what the next layers are poses of.
  const bool float32 = stored->positions.type == model::ScalarType::Float32;
  const auto reference = kept_->references.get(offset, [&]() -> Result<Reference> {
    return Reference{positionsOf(layer.vertices), layer.attributes, float32};
  });
  layer.pose = std::make_shared<const model::LayerPose>(
      model::LayerPose{(*reference)->points, model::Affine3x4::Identity(), (*reference)->float32});
  return layer;
}

Result<SlabSource::DecodedLayer> SlabSource::readPose(const ChunkHeader& header,
                                                      const Payload& payload) const {
  const auto wrong = [&](const std::string& message) {
    return file_->damaged(header.offset, "POSE: " + message);
  };
  const auto posed = decodePose(payload.view, features_);
  if (!posed) return wrong(posed.error().message);
  std::optional<std::uint64_t> place = header.offset - posed->layer;
  if (layerOf_) {
    place = layerOf_(header.offset, posed->layer);
    if (!place) {
      return wrong(
          fmt::format("its LAYR, {} bytes before it, is missing or damaged", posed->layer));
    }
  } else if (posed->layer == 0 || posed->layer >= header.offset) {
    return wrong("it moves no LAYR that comes before it");
  }
  const auto from = reference(*place);
  if (!from) return from.error();
  DecodedLayer layer;
  layer.attributes = (*from)->attributes;
  layer.pose = std::make_shared<const model::LayerPose>(
      model::LayerPose{(*from)->points, posed->pose, (*from)->float32});
  layer.vertices.reserve(layer.pose->reference->size());
  for (std::size_t i = 0; i < layer.pose->reference->size(); ++i) {
    layer.vertices.emplace_back() << layer.pose->at(i), posed->time;
  }
  return layer;
}

Result<SlabSource::ReferencePointer> SlabSource::reference(std::uint64_t offset) const {
  return kept_->references.get(offset, [&] { return readReference(offset); });
}

Result<SlabSource::Reference> SlabSource::readReference(std::uint64_t offset) const {
  auto chunk = file_->readChunk(offset, kLayer);
  if (!chunk) return chunk.error();
  auto layer = decodeLayer(chunk->payload.view, features_);
  if (!layer) return file_->damaged(offset, "LAYR: " + layer.error().message);
  std::vector<model::Point4> vertices(layer->size());
  if (auto set = unpackLayer(*layer, vertices, features_); !set) {
    return file_->damaged(offset, "LAYR: " + set.error().message);
  }
  return Reference{positionsOf(vertices), std::move(layer->attributes),
                   layer->positions.type == model::ScalarType::Float32};
}

Result<SlabSource::Parts> SlabSource::readParts(const IndexRecord& record) const {
  const ChunkFile& file = *file_;
  auto chunk = file.readChunk(record.slab, kSlab);
  if (!chunk) return chunk.error();
  const auto wrong = [&](const std::string& message) {
    return file.damaged(record.slab, "SLAB: " + message);
  };
  auto decoded = decodeSlab(chunk->payload.view, features_);
  if (!decoded) return wrong(decoded.error().message);
  if (layerOf_) decoded->parts = record.parts;
  if (!(record == IndexRecord{record.slab, chunk->header.bytes(), decoded->parts, decoded->time})) {
    return wrong("the index says something else than the slab itself");
  }
  auto shared = connectivity(record.connectivity());
  if (!shared) return shared.error();
  auto lower = layer(record.lower());
  if (!lower) return lower.error();
  auto upper = layer(record.upper());
  if (!upper) return upper.error();
  const Connectivity& counts = **shared;
  const std::uint64_t interior = counts.firstMean() - counts.lowerCount;
  if ((*lower)->vertices.size() != counts.lowerCount ||
      (*upper)->vertices.size() != counts.upperCount || decoded->interior.size() != interior) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, "
                    "the file {}, {} and {}",
                    counts.lowerCount, interior, counts.upperCount, (*lower)->vertices.size(),
                    decoded->interior.size(), (*upper)->vertices.size()));
  }
  return Parts{std::move(*decoded), std::move(*shared), std::move(*lower), std::move(*upper)};
}

Result<std::shared_ptr<const model::Slab>> SlabSource::readSlab(const IndexRecord& record) const {
  auto parts = readParts(record);
  if (!parts) return parts.error();
  const auto wrong = [&](const std::string& message) {
    return file_->damaged(record.slab, "SLAB: " + message);
  };
  const SlabChunk& own = parts->own;
  const DecodedLayer& lower = *parts->lower;
  const DecodedLayer& upper = *parts->upper;
  const auto slab = std::make_shared<model::Slab>();
  slab->connectivity = parts->connectivity;
  const Connectivity& connectivity = *slab->connectivity;
  // Use the slab's own times: the index may have -0 where it has 0.
  slab->timeBegin = own.time.begin;
  slab->timeEnd = own.time.end;
  slab->vertices.resize(connectivity.vertexCount);
  const auto interior = std::ranges::copy(lower.vertices, slab->vertices.begin()).out;
  std::ranges::copy(own.interior, interior);
  std::ranges::copy(upper.vertices, slab->vertices.begin() + connectivity.firstUpper());
  slab->upperPose = upper.pose;
  setMeans(connectivity, slab->vertices);
  auto attributes = joinedAttributes(
      connectivity,
      {lower.attributes, vertexRows(own.attributes, 0, own.interior.size()), upper.attributes},
      kMaxExpansion * file_->knownBytes());
  if (!attributes) return wrong(attributes.error().message);
  slab->attributes = std::move(*attributes);
  std::ranges::copy_if(own.attributes, std::back_inserter(slab->attributes), isOfCells);
  if (auto sound = checkSlab(*slab); !sound) return wrong(sound.error().message);
  const auto sameBounds = [](const model::Bounds4& a, const model::Bounds4& b) {
    return a.min == b.min && a.max == b.max;
  };
  if (!own.cellBounds.empty() &&
      !std::ranges::equal(own.cellBounds, boundsOfBlocks(connectivity, slab->vertices),
                          sameBounds)) {
    return wrong("the bounds of its blocks of cells are not those of their vertices");
  }
  if (record.extent && *record.extent != extentOf(*slab)) {
    return wrong("the index says other cells or bounds than the slab has");
  }
  if (auto sound = checkStorable(connectivity.cellAttributes, slab->attributes); !sound) {
    return wrong(sound.error().message);
  }
  return slab;
}

Result<std::shared_ptr<const model::LayeredSlab>> SlabSource::layered(std::size_t index) const {
  if (file_->remote()) plan(index);
  auto slab = withinMemory(file_->path(), [&] { return readLayered(records_[index]); });
  // An error is reported where the slab is read whole.
  return slab ? slab : std::shared_ptr<const model::LayeredSlab>();
}

Result<std::shared_ptr<const model::LayeredSlab>> SlabSource::readLayered(
    const IndexRecord& record) const {
  using Pointer = std::shared_ptr<const model::LayeredSlab>;
  const auto shared = connectivity(record.connectivity());
  if (!shared) return shared.error();
  const Connectivity& counts = **shared;
  if (counts.means.size() == 0) return Pointer();
  auto parts = readParts(record);
  if (!parts) return parts.error();
  const SlabChunk& own = parts->own;
  if (!parts->lower->attributes.empty() || !std::ranges::all_of(own.attributes, isOfCells) ||
      !parts->upper->attributes.empty()) {
    return Pointer();
  }
  const auto check = [&](std::span<const model::Point4> vertices, std::uint32_t first) {
    return checkVertices(vertices, counts, own.time, first);
  };
  auto sound =
      check(parts->lower->vertices, 0)
          .and_then([&] { return check(own.interior, counts.lowerCount); })
          .and_then([&] { return check(parts->upper->vertices, counts.firstUpper()); })
          .and_then([&] {
            return checkAttributes(own.attributes, counts.vertexCount, counts.cells.size());
          })
          .and_then([&] { return checkStorable(counts.cellAttributes, own.attributes); });
  if (!sound) return sound.error();
  SlabExtent extent{counts.cells.size(), {}};
  for (const auto* vertices : {&parts->lower->vertices, &own.interior, &parts->upper->vertices}) {
    for (const model::Point4& vertex : *vertices) extent.bounds.add(vertex.head<3>());
  }
  // Means can lie outside by rounding: whether the index is wrong is told by the whole slab.
  if (record.extent && *record.extent != extent) return Pointer();
  const auto verticesOf = [](const LayerPointer& layer) {
    return model::LayeredSlab::Layer(layer, &layer->vertices);
  };
  return std::make_shared<const model::LayeredSlab>(model::LayeredSlab{
      own.time, parts->connectivity, verticesOf(parts->lower), std::move(parts->own.interior),
      verticesOf(parts->upper), std::move(parts->own.attributes)});
}

}  // namespace t4d::formats
