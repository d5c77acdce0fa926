#include "formats/t4d/chunk_file.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "platform/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

bool isChunkType(const ChunkType& type) {
  const auto isLower = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto isUpper = [](char c) { return c >= 'A' && c <= 'Z'; };
  const bool isPrivate = isLower(type[0]);
  if (!isPrivate && !isUpper(type[0])) return false;
  return std::all_of(type.begin(), type.end(), [&](char c) {
    return isUpper(c) || (c >= '0' && c <= '9') || (isPrivate && isLower(c));
  });
}

bool hasSignature(std::span<const std::byte> bytes) {
  return std::memcmp(bytes.data(), kSignature.data(), kSignature.size()) == 0;
}

}  // namespace

Result<ChunkFile> ChunkFile::open(const std::filesystem::path& pathOrUrl) {
  auto source = openByteSource(pathOrUrl);
  if (!source) return source.error();
  return ChunkFile(std::move(*source));
}

Error ChunkFile::damaged(std::uint64_t offset, const std::string& message, ErrorCode code) const {
  return Error{code, message, placeOfByte(path(), offset), offset};
}

/// Callers have checked `offset` and `bytes` against the file's size.
Result<std::vector<std::byte>> ChunkFile::read(std::uint64_t offset, std::uint64_t bytes) const {
  // A server can lie about the size of a file, and a pipe has none: memory grows with what comes.
  constexpr std::uint64_t kStep = std::uint64_t{64} << 20;
  const std::uint64_t step = source_->sizeIsCertain() ? bytes : kStep;
  std::vector<std::byte> data;
  do {
    const std::size_t have = data.size();
    data.resize(have + std::min(step, bytes - have));
    auto done = source_->read(offset + have, std::span(data).subspan(have));
    if (!done) return done.error();
  } while (data.size() < bytes);
  return data;
}

Result<ChunkFile::Header> ChunkFile::readHeader() const {
  if (size() < kFileHeaderBytes) {
    return damaged(0, fmt::format("the file has {} bytes; a .t4d file has at least {}", size(),
                                  kFileHeaderBytes + kChunkHeaderBytes));
  }
  auto bytes = read(0, kFileHeaderBytes);
  if (!bytes) return bytes.error();
  std::uint32_t crc = 0;
  std::memcpy(&crc, bytes->data() + kFileHeaderCopyBytes, sizeof crc);
  if (hasSignature(*bytes) && crc != platform::crc32c(bytes->data(), kFileHeaderCopyBytes)) {
    return damaged(8, "the file header's checksum does not match: the file is damaged");
  }
  return decodeHeader(std::span(*bytes).first<kFileHeaderCopyBytes>());
}

Result<ChunkFile::Header> ChunkFile::decodeHeader(
    std::span<const std::byte, kFileHeaderCopyBytes> copy) const {
  if (!hasSignature(copy)) {
    const bool almost = std::memcmp(copy.data() + 1, kSignature.data() + 1, 3) == 0;
    auto refused = damaged(0, almost ? "the signature is damaged, as by a transfer in text mode; "
                                       "copy the file again in binary mode"
                                     : "is not a .t4d file: the signature is missing");
    if (!almost) refused.remedy = Remedy::OtherFormat;
    return refused;
  }
  ByteReader from(copy);
  from.takeBytes(kSignature.size());
  Header header;
  header.major = from.take<std::uint16_t>();
  header.minor = from.take<std::uint16_t>();
  const auto flags = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (header.major != kMajorVersion) {
    return damaged(8,
                   fmt::format("is of version {}.{}; this program reads {}.x", header.major,
                               header.minor, kMajorVersion),
                   ErrorCode::Unsupported);
  }
  if ((flags & ~kFlagIndexed) != 0) {
    return damaged(12, fmt::format("the file header has unknown flags {:#x}", flags),
                   ErrorCode::Unsupported);
  }
  if (reserved != 0) return damaged(16, "the file header's reserved bytes are not zero");
  header.indexed = (flags & kFlagIndexed) != 0;
  std::ranges::copy(copy, header.bytes.begin());
  return header;
}

Result<ChunkFile::Footer> ChunkFile::readFooter(std::uint64_t end) const {
  if (end < kFileHeaderBytes + kFooterBytes) {
    return damaged(end, "the file is truncated before its footer");
  }
  const std::uint64_t offset = end - kFooterBytes;
  auto bytes = read(offset, kFooterBytes);
  if (!bytes) return bytes.error();
  ByteReader from(*bytes);
  Footer footer;
  footer.index = from.take<std::uint64_t>();
  footer.done = from.take<std::uint64_t>();
  const auto length = from.take<std::uint64_t>();
  footer.indexChecksum = from.take<std::uint32_t>();
  const std::size_t covered = from.position();
  const auto crc = from.take<std::uint32_t>();
  if (std::memcmp(bytes->data() + from.position(), kEndSignature.data(), kEndSignature.size()) !=
      0) {
    return damaged(offset, "the footer is missing: the file is truncated, or something follows it");
  }
  if (crc != platform::crc32c(bytes->data(), covered)) {
    return damaged(offset, "the footer's checksum does not match: the file is damaged");
  }
  if (length != end) {
    return damaged(
        offset, fmt::format("the footer says that the file has {} bytes; it has {}", length, end));
  }
  return footer;
}

Result<ChunkHeader> ChunkFile::readChunkHeader(std::uint64_t offset) const {
  if (offset % kAlignment != 0 || offset < kFileHeaderBytes || offset > size() ||
      size() - offset < kChunkHeaderBytes) {
    return damaged(offset, fmt::format("no chunk can be here: the file has {} bytes", size()));
  }
  auto bytes = read(offset, kChunkHeaderBytes);
  if (!bytes) return bytes.error();
  auto header = chunkHeader(offset, *bytes);
  if (!header || !expected_) return header;
  const auto known = std::ranges::lower_bound(*expected_, offset, {}, &ChunkHeader::offset);
  const bool isKnown = known != expected_->end() && known->offset == offset;
  if (isKnown ? *known != *header : !expectsOthers_) {
    return damaged(offset,
                   fmt::format("the chunk {} is not what the index says, or what was here "
                               "before: the file is damaged, or has changed while it was read",
                               header->name()));
  }
  return header;
}

void ChunkFile::expectChunks(std::vector<ChunkHeader> chunks) {
  expected_ = std::move(chunks);
  if (!remote()) return;
  for (const ChunkHeader& chunk : *expected_) {
    if (chunk.type == kLayer) layers_.push_back({chunk.offset, chunk.end()});
  }
}

ChunkFile ChunkFile::withChunks(std::vector<ChunkHeader> chunks) const {
  ChunkFile file(source_);
  file.cut_ = cut_;
  file.expectChunks(std::move(chunks));
  file.expectsOthers_ = true;
  return file;
}

Result<std::uint64_t> ChunkFile::readLength(std::uint64_t end) const {
  auto bytes = read(end - sizeof(std::uint64_t), sizeof(std::uint64_t));
  if (!bytes) return bytes.error();
  return ByteReader(*bytes).take<std::uint64_t>();
}

ByteRange ChunkFile::placeOf(std::uint64_t offset) const {
  if (!expected_) return {};
  const auto known = std::ranges::lower_bound(*expected_, offset, {}, &ChunkHeader::offset);
  if (known == expected_->end() || known->offset != offset) return {};
  return {offset, known->end()};
}

ByteRange ChunkFile::likelyLayerOf(std::uint64_t offset) const {
  const auto next = std::ranges::lower_bound(layers_, offset, {}, &ByteRange::begin);
  // A layer that is no POSE moves no other.
  const bool isLayer = next != layers_.end() && next->begin == offset;
  return isLayer || next == layers_.begin() ? ByteRange{} : next[-1];
}

std::optional<ChunkHeader> ChunkFile::findChunk(std::uint64_t from) const {
  // The block size of most disks: if one block is unreadable, the next may be readable.
  constexpr std::uint64_t kBlock = 4096;
  constexpr std::size_t kFlagsAt = sizeof(ChunkType);
  for (std::uint64_t at = padded(from); at < size();) {
    const std::uint64_t next = (at / kBlock + 1) * kBlock;
    const std::uint64_t end = std::min(next + kChunkHeaderBytes - kAlignment, size());
    if (const auto bytes = read(at, end - at)) {
      const std::span<const std::byte> all(*bytes);
      for (std::size_t i = 0; i + kChunkHeaderBytes <= all.size(); i += kAlignment) {
        ChunkType type;
        std::memcpy(type.data(), all.data() + i, type.size());
        std::uint32_t flags = 0;
        std::memcpy(&flags, all.data() + i + kFlagsAt, sizeof flags);
        // Compute the checksum only where the bytes look like a chunk.
        if (!isChunkType(type) || (flags & ~kFlagCritical) != 0) continue;
        if (auto header = chunkHeader(at + i, all.subspan(i, kChunkHeaderBytes))) return *header;
      }
    }
    at = next;
  }
  return std::nullopt;
}

Result<ChunkHeader> ChunkFile::chunkHeader(std::uint64_t offset,
                                           std::span<const std::byte> bytes) const {
  const auto stored = bytes.first<kChunkHeaderBytes>();
  if (!hasRightChecksum(stored)) {
    return damaged(offset, "the checksum of a chunk's header does not match: the file is damaged");
  }
  const ChunkHeader header = decodeChunkHeader(stored.first<kDirectoryEntryBytes>(), offset);
  if (!isChunkType(header.type)) {
    return damaged(offset,
                   "the chunk's type is not four letters or digits, of the kind of the first");
  }
  if ((header.flags & ~kFlagCritical) != 0) {
    return damaged(offset, fmt::format("the chunk has unknown flags {:#x}", header.flags),
                   ErrorCode::Unsupported);
  }
  constexpr ChunkType kKnown[] = {kHead, kConnectivity, kLayer, kPose, kSlab, kDone, kIndex};
  const bool known =
      std::find(std::begin(kKnown), std::end(kKnown), header.type) != std::end(kKnown);
  if (known && !header.critical()) {
    return damaged(offset, fmt::format("the chunk {} lacks its critical flag", header.name()));
  }
  const std::uint64_t left = size() - offset - kChunkHeaderBytes;
  // Rounding up to the padding cannot overflow once the length is within the file.
  if (header.payloadBytes > left || padded(header.payloadBytes) > left) {
    if (size() == ByteSource::kUnknownSize) {
      return damaged(offset, fmt::format("the chunk {} claims {} bytes, more than any file has",
                                         header.name(), header.payloadBytes));
    }
    return damaged(offset,
                   fmt::format("the chunk {} claims {} bytes where {} are left: the file is "
                               "truncated",
                               header.name(), header.payloadBytes, left));
  }
  const bool plain = header.type == kHead || header.type == kDone;
  if (plain && header.blocks > 0) {
    return damaged(offset, fmt::format("the chunk {} has blocks", header.name()));
  }
  const std::uint64_t table = header.blocks * std::uint64_t{kBlockEntryBytes};
  const bool sound = header.blocks == 0 ? header.frontBytes == header.payloadBytes
                                        : header.frontBytes <= header.payloadBytes &&
                                              header.frontBytes % kAlignment == 0;
  if (!sound || table > header.frontBytes) {
    return damaged(
        offset, fmt::format("the chunk {} has a front of {} of its {} bytes, and {} blocks",
                            header.name(), header.frontBytes, header.payloadBytes, header.blocks));
  }
  return header;
}

Result<Payload> ChunkFile::readPayload(const ChunkHeader& header) const {
  auto bytes = read(header.payload(), padded(header.payloadBytes));
  if (!bytes) return bytes.error();
  Payload payload{std::move(*bytes), {}};
  auto view = payloadOf(header, payload.bytes);
  if (!view) return damagedIn(header, view.error());
  payload.view = std::move(*view);
  return payload;
}

Error ChunkFile::damagedIn(const ChunkHeader& header, const Error& error) const {
  return damaged(error.offset ? header.payload() + *error.offset : header.offset, error.message);
}

Result<ChunkHeader> ChunkFile::headerOf(std::uint64_t offset, ChunkType type) const {
  auto header = readChunkHeader(offset);
  if (header && header->type != type) {
    return damaged(offset, fmt::format("a chunk {} is here, where {} is expected", header->name(),
                                       std::string(type.begin(), type.end())));
  }
  return header;
}

Result<ChunkFile::Chunk> ChunkFile::readChunk(std::uint64_t offset, ChunkType type) const {
  auto header = headerOf(offset, type);
  if (!header) return header.error();
  auto payload = readPayload(*header);
  if (!payload) return payload.error();
  return Chunk{*header, std::move(*payload)};
}

Result<PartialPayload> ChunkFile::readPartly(std::uint64_t offset, ChunkType type) const {
  auto header = headerOf(offset, type);
  if (!header) return header.error();
  PartialPayload payload;
  payload.file_ = this;
  payload.header_ = *header;
  const std::uint64_t size = padded(header->payloadBytes);
  payload.bytes_ = std::make_unique_for_overwrite<std::byte[]>(size);
  const std::span<std::byte> bytes(payload.bytes_.get(), size);
  const auto front = bytes.first(header->frontBytes);
  if (auto done = source_->read(header->payload(), front); !done) return done.error();
  auto view = placesOf(*header, bytes);
  if (!view) return damagedIn(*header, view.error());
  payload.view_ = std::move(*view);
  payload.loaded_ = std::make_unique<PartialPayload::Loaded>();
  payload.loaded_->blocks.resize(header->blocks);
  return payload;
}

Result<void> PartialPayload::load(std::span<const std::byte> block) const {
  const auto found =
      std::ranges::find(view_.blocks, block.data(), [](const auto& each) { return each.data(); });
  const auto number = static_cast<std::uint32_t>(found - view_.blocks.begin());
  const std::scoped_lock lock(loaded_->mutex);
  if (loaded_->blocks[number]) return {};
  const std::uint64_t at = static_cast<std::uint64_t>(block.data() - bytes_.get());
  const std::span<std::byte> into(bytes_.get() + at, padded(block.size()));
  if (auto done = file_->source_->read(header_.payload() + at, into); !done) return done;
  const std::span<const std::byte> all(bytes_.get(), padded(header_.payloadBytes));
  if (auto sound = checkBlock(header_, all, view_, number); !sound) {
    return file_->damagedIn(header_, sound.error());
  }
  loaded_->blocks[number] = true;
  return {};
}

}  // namespace t4d::formats
