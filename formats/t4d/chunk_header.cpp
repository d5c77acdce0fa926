#include "formats/t4d/chunk_header.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "platform/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

constexpr std::size_t kCoveredBytes = kDirectoryEntryBytes;
static_assert(kChunkHeaderBytes == kCoveredBytes + sizeof(std::uint32_t));

std::uint32_t storedChecksum(const std::byte* header) {
  std::uint32_t checksum = 0;
  std::memcpy(&checksum, header + kCoveredBytes, sizeof checksum);
  return checksum;
}

}  // namespace

ChunkHeaderBytes encodeChunkHeader(const ChunkHeader& header) {
  ByteWriter bytes;
  bytes.putBytes(header.type.data(), header.type.size());
  bytes.put(header.flags);
  bytes.put(header.payloadBytes);
  bytes.put(header.frontBytes);
  bytes.put(header.blocks);
  bytes.put(header.frontCrc);
  bytes.put(platform::crc32c(bytes.data(), bytes.size()));
  ChunkHeaderBytes encoded;
  std::copy_n(bytes.data(), encoded.size(), encoded.begin());
  return encoded;
}

std::uint32_t checksumOf(const ChunkHeader& header) {
  return storedChecksum(encodeChunkHeader(header).data());
}

bool hasRightChecksum(std::span<const std::byte, kChunkHeaderBytes> bytes) {
  return platform::crc32c(bytes.data(), kCoveredBytes) == storedChecksum(bytes.data());
}

ChunkHeader decodeChunkHeader(std::span<const std::byte, kDirectoryEntryBytes> bytes,
                              std::uint64_t offset) {
  ByteReader from(bytes);
  ChunkHeader header;
  header.offset = offset;
  for (char& letter : header.type) letter = from.take<char>();
  header.flags = from.take<std::uint32_t>();
  header.payloadBytes = from.take<std::uint64_t>();
  header.frontBytes = from.take<std::uint32_t>();
  header.blocks = from.take<std::uint32_t>();
  header.frontCrc = from.take<std::uint32_t>();
  return header;
}

ChunkFront frontOf(ChunkType type, const PayloadWriter& payload, std::uint64_t offset,
                   std::uint32_t flags) {
  ChunkFront made;
  std::uint64_t blockBytes = 0;
  for (const auto& block : payload.blocks()) {
    made.front.put(static_cast<std::uint32_t>(block.size()));
    made.front.put(block.checksum());
    blockBytes += padded(block.size());
  }
  made.front.putBytes(payload.data(), payload.size());
  made.header.type = type;
  made.header.flags = flags;
  made.header.payloadBytes = made.front.size() + blockBytes;
  made.header.frontBytes = static_cast<std::uint32_t>(made.front.size());
  made.header.blocks = static_cast<std::uint32_t>(payload.blocks().size());
  made.header.frontCrc = platform::crc32c(made.front.data(), made.front.size());
  made.header.offset = offset;
  return made;
}

namespace {

/// `at` is an offset in the payload, if one is known.
Error wrongIn(const ChunkHeader& header, std::optional<std::uint64_t> at, const std::string& what) {
  Error error{ErrorCode::InvalidInput,
              fmt::format("in the chunk {} the {}: the file is damaged", header.name(), what),
              {}};
  error.offset = at;
  return error;
}

bool isZero(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

}  // namespace

Result<void> checkFront(const ChunkHeader& header, std::span<const std::byte> front) {
  const std::uint32_t crc = platform::crc32c(front.data(), front.size());
  if (crc != header.frontCrc) {
    Error error{ErrorCode::InvalidInput,
                fmt::format("the checksum of the chunk {} is {:08x}, not {:08x}: the file is "
                            "damaged",
                            header.name(), crc, header.frontCrc),
                {}};
    return error;
  }
  const auto table = front.first(header.blocks * kBlockEntryBytes);
  std::uint64_t blockBytes = 0;
  for (ByteReader sizes(table); sizes.left() > 0; sizes.takeBytes(sizeof(std::uint32_t))) {
    blockBytes += padded(sizes.take<std::uint32_t>());
  }
  if (blockBytes != header.payloadBytes - front.size()) {
    return wrongIn(header, std::nullopt,
                   fmt::format("table says that its blocks take {} bytes, not the {} that are left",
                               blockBytes, header.payloadBytes - front.size()));
  }
  return {};
}

Result<PayloadView> placesOf(const ChunkHeader& header, std::span<const std::byte> payload) {
  const auto front = payload.first(header.frontBytes);
  if (auto sound = checkFront(header, front); !sound) return sound.error();
  const auto table = front.first(header.blocks * kBlockEntryBytes);
  PayloadView view{front.subspan(table.size()), {}};
  view.blocks.reserve(header.blocks);
  ByteReader blocks(payload.subspan(front.size()));
  for (ByteReader sizes(table); sizes.left() > 0; sizes.takeBytes(sizeof(std::uint32_t))) {
    const auto size = sizes.take<std::uint32_t>();
    view.blocks.push_back(blocks.takeBytes(padded(size)).first(size));
  }
  return view;
}

Result<void> checkBlock(const ChunkHeader& header, std::span<const std::byte> payload,
                        const PayloadView& view, std::uint32_t number) {
  const auto block = view.blocks[number];
  const auto at = static_cast<std::uint64_t>(block.data() - payload.data());
  ByteReader entry(payload.subspan(number * kBlockEntryBytes + sizeof(std::uint32_t)));
  const auto expected = entry.take<std::uint32_t>();
  const std::uint32_t found = platform::crc32c(block.data(), block.size());
  if (found != expected) {
    return wrongIn(
        header, at,
        fmt::format("checksum of block {} is {:08x}, not {:08x}", number, found, expected));
  }
  if (!isZero(payload.subspan(at + block.size(), padded(block.size()) - block.size()))) {
    return wrongIn(header, at, fmt::format("padding of block {} is not zero", number));
  }
  return {};
}

Result<PayloadView> payloadOf(const ChunkHeader& header, std::span<const std::byte> payload) {
  auto view = placesOf(header, payload);
  if (!view) return view;
  for (std::uint32_t i = 0; i < header.blocks; ++i) {
    if (auto checked = checkBlock(header, payload, *view, i); !checked) {
      return checked.error();
    }
  }
  if (!isZero(payload.subspan(header.payloadBytes))) {
    return wrongIn(header, std::nullopt, "padding is not zero");
  }
  return view;
}

}  // namespace t4d::formats
