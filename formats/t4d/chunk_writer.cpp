#include "formats/t4d/chunk_writer.h"

#include <algorithm>
#include <array>

#include "formats/t4d/chunk_counts.h"
#include "platform/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// The file header.
ByteWriter fileHeaderOf(std::uint16_t minorVersion, bool indexed) {
  ByteWriter header;
  header.putBytes(kSignature.data(), kSignature.size());
  header.put(kMajorVersion);
  header.put(minorVersion);
  header.put(indexed ? kFlagIndexed : std::uint32_t{0});
  header.put(std::uint32_t{0});
  header.put(platform::crc32c(header.data(), header.size()));
  return header;
}

}  // namespace

Result<void> ChunkWriter::begin(const std::string& head, std::uint16_t minorVersion) {
  const ByteWriter header = fileHeaderOf(minorVersion, indexed_);
  if (auto done = out_.write(header.data(), header.size()); !done) return done;
  std::copy_n(header.data(), front_.fileHeader.size(), front_.fileHeader.begin());
  PayloadWriter payload;
  payload.putBytes(head.data(), head.size());
  front_.head = head;
  const auto offset = put(kHead, payload);
  return offset ? Result<void>() : offset.error();
}

Result<void> ChunkWriter::writePadded(std::span<const std::byte> bytes) {
  constexpr std::array<std::byte, kAlignment> kZeros{};
  if (auto done = out_.write(bytes.data(), bytes.size()); !done) return done;
  return out_.write(kZeros.data(), padded(bytes.size()) - bytes.size());
}

Result<std::uint64_t> ChunkWriter::put(ChunkType type, const PayloadWriter& payload,
                                       std::uint32_t flags) {
  const std::uint64_t offset = out_.size();
  const auto [header, front] = frontOf(type, payload, offset, flags);
  if (auto done = writePadded(encodeChunkHeader(header)); !done) return done.error();
  if (auto done = writePadded(front.bytes()); !done) return done.error();
  std::vector<std::byte> space;
  for (const StoredBlock& block : payload.blocks()) {
    const auto bytes = block.bytes(space);
    if (!bytes) return bytes.error();
    if (auto done = writePadded(*bytes); !done) return done.error();
  }
  chunks_.push_back(header);
  return offset;
}

Result<std::uint64_t> ChunkWriter::putCopy(ChunkHeader header, std::span<const std::byte> payload) {
  header.offset = out_.size();
  if (auto done = writePadded(encodeChunkHeader(header)); !done) return done.error();
  if (auto done = writePadded(payload); !done) return done.error();
  chunks_.push_back(header);
  return header.offset;
}

Result<std::uint64_t> ChunkWriter::finish(const std::vector<BodySummary>& bodies) {
  if (indexed_) {
    if (auto paged = putPages(bodies.size()); !paged) return paged.error();
  }
  auto doneOffset = put(kDone, encodeDone({chunks_.size(), bodies}));
  if (!doneOffset) return doneOffset;
  if (indexed_) {
    if (auto put = putIndexAndFooter(*doneOffset); !put) return put.error();
    if (chunks_.failed() || slabs_.failed()) {
      return fail(ErrorCode::Failed, "cannot read a temporary file (TMPDIR says where)");
    }
  }
  const std::uint64_t size = out_.size();
  if (auto committed = out_.commit(); !committed) return committed.error();
  return size;
}

Result<void> ChunkWriter::putPages(std::size_t bodyCount) {
  PageList list{chunks_.front(), {}, {}, 0};
  const auto putPage = [&](const PageRun& run) -> Result<void> {
    const auto offset = put(kPage, encodePage(run, out_.size(), level_), 0);
    if (!offset) return offset.error();
    list.pages.push_back(entryOf(run, *offset));
    list.pages.back().checksum = checksumOf(chunks_.back());
    return {};
  };
  auto paged = eachPageRun(chunks_, slabs_, bodyCount, pageSlabs_, putPage);
  if (!paged || list.pages.empty()) return paged;
  for (const ChunkHeader& chunk : chunks_.all()) addChunk(list.chunks, chunk.type, chunk.bytes());
  list.offset = out_.size();
  const auto last = put(kPageList, encodePageList(list), 0);
  return last ? raiseVersion() : last.error();
}

/// Version 1.1 has pages.
Result<void> ChunkWriter::raiseVersion() {
  const ByteWriter header = fileHeaderOf(kMinorVersion, indexed_);
  std::copy_n(header.data(), front_.fileHeader.size(), front_.fileHeader.begin());
  return out_.rewrite(0, header.data(), header.size());
}

Result<void> ChunkWriter::putIndexAndFooter(std::uint64_t doneOffset) {
  const auto indexOffset = put(kIndex, encodeIndex(front_, chunks_.rows(), slabs_.rows(), level_));
  if (!indexOffset) return indexOffset.error();
  ByteWriter footer;
  footer.put(*indexOffset);
  footer.put(doneOffset);
  footer.put(std::uint64_t{out_.size() + kFooterBytes});
  footer.put(checksumOf(chunks_.back()));
  footer.put(platform::crc32c(footer.data(), footer.size()));
  footer.putBytes(kEndSignature.data(), kEndSignature.size());
  return out_.write(footer.data(), footer.size());
}

}  // namespace t4d::formats
