#include "t4d/formats/t4d/chunk_writer.h"

#include <algorithm>
#include <array>

#include "t4d/system/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

Result<void> ChunkWriter::begin(const std::string& head, std::uint16_t minorVersion) {
  ByteWriter header;
  header.putBytes(kSignature.data(), kSignature.size());
  header.put(kMajorVersion);
  header.put(minorVersion);
  header.put(indexed_ ? kFlagIndexed : std::uint32_t{0});
  header.put(std::uint32_t{0});
  header.put(system::crc32c(header.data(), header.size()));
  if (auto done = out_.write(header.data(), header.size()); !done) return done;
  std::copy_n(header.data(), index_.fileHeader.size(), index_.fileHeader.begin());
  PayloadWriter payload;
  payload.putBytes(head.data(), head.size());
  index_.head = head;
  const auto offset = put(kHead, payload);
  return offset ? Result<void>() : pass(offset.error());
}

Result<void> ChunkWriter::writePadded(std::span<const std::byte> bytes) {
  constexpr std::array<std::byte, kAlignment> kZeros{};
  if (auto done = out_.write(bytes.data(), bytes.size()); !done) return done;
  return out_.write(kZeros.data(), padded(bytes.size()) - bytes.size());
}

Result<std::uint64_t> ChunkWriter::put(ChunkType type, const PayloadWriter& payload) {
  const std::uint64_t offset = out_.size();
  const auto [header, front] = frontOf(type, payload, offset);
  if (auto done = writePadded(encodeChunkHeader(header)); !done) return pass(done.error());
  if (auto done = writePadded(front.bytes()); !done) return pass(done.error());
  std::vector<std::byte> space;
  for (const StoredBlock& block : payload.blocks()) {
    const auto bytes = block.bytes(space);
    if (!bytes) return pass(bytes.error());
    if (auto done = writePadded(*bytes); !done) return pass(done.error());
  }
  index_.chunks.push_back(header);
  return offset;
}

Result<std::uint64_t> ChunkWriter::putCopy(ChunkHeader header, std::span<const std::byte> payload) {
  header.offset = out_.size();
  if (auto done = writePadded(encodeChunkHeader(header)); !done) return pass(done.error());
  if (auto done = writePadded(payload); !done) return pass(done.error());
  index_.chunks.push_back(header);
  return header.offset;
}

Result<std::uint64_t> ChunkWriter::finish(const std::vector<BodySummary>& bodies) {
  auto doneOffset = put(kDone, encodeDone({index_.chunks.size(), bodies}));
  if (!doneOffset) return doneOffset;
  if (indexed_) {
    if (auto put = putIndexAndFooter(*doneOffset); !put) return pass(put.error());
  }
  const std::uint64_t size = out_.size();
  if (auto committed = out_.commit(); !committed) return pass(committed.error());
  return size;
}

Result<void> ChunkWriter::putIndexAndFooter(std::uint64_t doneOffset) {
  const auto indexOffset = put(kIndex, encodeIndex(index_, level_));
  if (!indexOffset) return pass(indexOffset.error());
  ByteWriter footer;
  footer.put(*indexOffset);
  footer.put(doneOffset);
  footer.put(std::uint64_t{out_.size() + kFooterBytes});
  footer.put(checksumOf(index_.chunks.back()));
  footer.put(system::crc32c(footer.data(), footer.size()));
  footer.putBytes(kEndSignature.data(), kEndSignature.size());
  return out_.write(footer.data(), footer.size());
}

}  // namespace t4d::formats
