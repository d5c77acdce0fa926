#include "formats/t4d/part_copier.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <string_view>

#include "platform/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

// Offsets in the fields of a POSE and of a SLAB (SPEC.md).
constexpr std::size_t kLayerOfPoseAt = 8;
constexpr std::size_t kPartsOfSlabAt = 16;  // connectivity, lower, upper

ChunkHeader withoutOffset(ChunkHeader header) {
  header.offset = 0;
  return header;
}

/// A chunk whose distances may be changed.
class Changed {
 public:
  Changed(const ChunkHeader& header, std::span<const std::byte> payload)
      : header_(header), payload_(payload.begin(), payload.end()) {}

  void setDistance(std::size_t field, std::uint64_t distance) {
    std::byte* at = payload_.data() + header_.blocks * kBlockEntryBytes + field;
    std::memcpy(at, &distance, sizeof distance);
  }
  std::span<const std::byte> payload() const { return payload_; }
  /// The header with the checksum of the present front.
  ChunkHeader header() const {
    ChunkHeader header = header_;
    header.frontCrc = platform::crc32c(payload_.data(), header.frontBytes);
    return header;
  }

 private:
  ChunkHeader header_;
  std::vector<std::byte> payload_;
};

std::span<const std::byte> frontOf(const ChunkFile::Chunk& chunk) {
  return std::span(chunk.payload.bytes).first(chunk.header.frontBytes);
}

std::uint64_t layerOf(const ChunkFile::Chunk& pose) {
  std::uint64_t distance = 0;
  const std::size_t table = pose.header.blocks * kBlockEntryBytes;
  std::memcpy(&distance, pose.payload.bytes.data() + table + kLayerOfPoseAt, sizeof distance);
  return pose.header.offset - distance;
}

/// Counts what T4dWriter counts.
std::size_t countedBytes(const ChunkFile::Chunk& chunk) {
  const auto table = frontOf(chunk).first(chunk.header.blocks * kBlockEntryBytes);
  std::size_t bytes = chunk.header.frontBytes - table.size();
  for (ByteReader sizes(table); sizes.left() > 0; sizes.takeBytes(sizeof(std::uint32_t))) {
    bytes += sizes.take<std::uint32_t>();
  }
  return bytes;
}

}  // namespace

void PartCopier::begin(const std::filesystem::path& path, const ChunkFile& file,
                       const std::vector<std::uint64_t>& lowers) {
  path_ = path;
  file_ = &file;
  given_ = PartWindow(uppers_.size());
  uppersThere_ = lowers;
  placed_.clear();
  atSeam_.clear();
  seen_.clear();
  for (std::size_t body = 0; body < lowers.size(); ++body) {
    if (lowers[body] == 0) continue;
    placed_[lowers[body]] = uppers_[body];
    atSeam_.insert(lowers[body]);
  }
}

Result<std::uint64_t> PartCopier::copy(const ChunkHeader& header,
                                       std::span<const std::byte> payload) {
  auto offset = into_.putCopy(header, payload);
  if (!offset) return offset;
  ChunkHeader there = header;
  there.offset = *offset;
  window_.add(there);
  return offset;
}

Result<bool> PartCopier::isSame(const Stored& one, const ChunkHeader& other) const {
  const auto file = ChunkFile::open(one.file);
  if (!file) return file.error();
  const auto before = file->readPayload(one.header);
  if (!before) return before.error();
  const auto now = file_->readPayload(other);
  if (!now) return now.error();
  return before->bytes == now->bytes;
}

Result<bool> PartCopier::takeStored(const ChunkFile::Chunk& chunk) {
  const ChunkHeader header = withoutOffset(chunk.header);
  // A connectivity that a part has twice is a spare copy.
  const auto key = encodeChunkHeader(header);
  const std::string_view text(reinterpret_cast<const char*>(key.data()), key.size());
  if (!seen_.insert(std::hash<std::string_view>()(text)).second) return false;
  for (const Stored& one : stored_) {
    const bool alike = withoutOffset(one.header) == header &&
                       std::ranges::equal(one.front, frontOf(chunk)) &&
                       window_.find(kConnectivity, one.offset) != nullptr;
    const auto same = alike ? isSame(one, chunk.header) : Result<bool>(false);
    if (!same) return same;
    if (!*same) continue;
    placed_[chunk.header.offset] = one.offset;
    return true;
  }
  return false;
}

/// Keeps what T4dWriter keeps to find connectivities that are equal.
void PartCopier::store(const ChunkFile::Chunk& chunk, std::uint64_t offset) {
  const std::size_t counted = countedBytes(chunk);
  const auto front = frontOf(chunk);
  stored_.push_back({path_, chunk.header, {front.begin(), front.end()}, counted, offset});
  storedBytes_ += counted;
  const std::size_t least = anySize_ ? 1 : 0;
  while (stored_.size() > least &&
         (storedBytes_ > kRememberedBytes ||
          window_.find(kConnectivity, stored_.front().offset) == nullptr)) {
    storedBytes_ -= stored_.front().counted;
    stored_.pop_front();
  }
}

Result<std::uint64_t> PartCopier::nameable(std::uint64_t offset, ChunkType type) {
  const std::uint64_t placed = placed_.at(offset);
  if (window_.find(type, placed) != nullptr) return placed;
  const auto chunk = readForCopy(*file_, *given_.find(type, offset));
  if (!chunk) return chunk.error();
  const auto again = copy(chunk->header, chunk->payload.bytes);
  if (again) placed_[offset] = *again;
  return again;
}

Result<void> PartCopier::put(const ChunkFile::Chunk& chunk) {
  const ChunkHeader& header = chunk.header;
  given_.add(header);
  forgetPlaces();
  if (atSeam_.contains(header.offset)) return {};
  if (header.type == kConnectivity) {
    const auto taken = takeStored(chunk);
    if (!taken) return taken.error();
    if (*taken) return {};
  }
  Result<std::uint64_t> offset;
  if (header.type == kPose) {
    const std::uint64_t old = layerOf(chunk);
    const auto layer = nameable(old, kLayer);
    if (!layer) return layer.error();
    Changed changed(header, chunk.payload.bytes);
    changed.setDistance(kLayerOfPoseAt, into_.size() - *layer);
    offset = copy(changed.header(), changed.payload());
  } else {
    offset = copy(header, chunk.payload.bytes);
  }
  if (!offset) return offset.error();
  placed_[header.offset] = *offset;
  if (header.type == kConnectivity) store(chunk, *offset);
  return {};
}

Result<void> PartCopier::putSlab(const ChunkFile::Chunk& chunk, const IndexRecord& record) {
  std::uint64_t& upperOfBody = uppers_[record.parts.body];
  std::uint64_t& upperThere = uppersThere_[record.parts.body];
  std::array<std::uint64_t, 3> parts = {record.connectivity(), record.lower(), record.upper()};
  for (std::uint64_t& part : parts) {
    if (part == 0) continue;
    // The layer with which the body ended before may be as far back as it is.
    if (&part == &parts[1] && part == upperThere) {
      part = upperOfBody;
      continue;
    }
    const auto placed = nameable(part, given_.find(kConnectivity, part) != nullptr ? kConnectivity
                                       : given_.find(kLayer, part) != nullptr      ? kLayer
                                                                                   : kPose);
    if (!placed) return placed.error();
    part = *placed;
  }
  const auto distance = [&](std::uint64_t part) { return part == 0 ? 0 : into_.size() - part; };
  const SlabParts moved = {distance(parts[0]), distance(parts[1]), distance(parts[2]),
                           record.parts.body};
  Changed changed(chunk.header, chunk.payload.bytes);
  changed.setDistance(kPartsOfSlabAt, moved.connectivity);
  changed.setDistance(kPartsOfSlabAt + 8, moved.lower);
  changed.setDistance(kPartsOfSlabAt + 16, moved.upper);
  const auto offset = copy(changed.header(), changed.payload());
  if (!offset) return offset.error();
  into_.addSlab({*offset, record.slabBytes, moved, record.time, record.extent});
  upperOfBody = parts[2];
  upperThere = record.upper();
  return {};
}

/// Keeps the places of those chunks alone that this part may still name.
void PartCopier::forgetPlaces() {
  constexpr std::size_t kSpare = 1024;
  if (placed_.size() < forgetAt_) return;
  std::erase_if(placed_, [&](const auto& place) {
    return !atSeam_.contains(place.first) && given_.find(kConnectivity, place.first) == nullptr &&
           given_.findLayer(place.first) == nullptr;
  });
  forgetAt_ = 2 * placed_.size() + kSpare;
}

}  // namespace t4d::formats
