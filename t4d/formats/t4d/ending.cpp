#include "t4d/formats/t4d/ending.h"

#include <algorithm>

#include <fmt/format.h>

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// Reads a chunk that the footer refers to.
Result<ChunkFile::Chunk> readNamed(const ChunkFile& file, std::uint64_t offset, ChunkType type) {
  const std::uint64_t footer = file.size() - kFooterBytes;
  if (offset % kAlignment != 0 || offset < kFileHeaderBytes || offset >= footer) {
    return file.damaged(footer, fmt::format("the footer says that {} is at byte {}",
                                            std::string(type.begin(), type.end()), offset));
  }
  return file.readChunk(offset, type);
}

}  // namespace

Result<Ending> readEnding(const ChunkFile& file, const Features& features) {
  auto footer = file.readFooter();
  if (!footer) return pass(footer.error());
  auto done = readNamed(file, footer->done, kDone);
  if (!done) return pass(done.error());
  auto index = readNamed(file, footer->index, kIndex);
  if (!index) return pass(index.error());
  if (done->header.end() != footer->index) {
    return file.damaged(done->header.end(), "the index does not follow the end mark at once");
  }
  if (index->header.end() != file.size() - kFooterBytes) {
    return file.damaged(index->header.end(), "the footer does not follow the index at once");
  }
  if (checksumOf(index->header) != footer->indexChecksum) {
    return file.damaged(file.size() - kFooterBytes, "the footer is that of another index");
  }
  auto decodedDone = decodeDone(done->payload.view);
  if (!decodedDone) return file.damaged(footer->done, "DONE: " + decodedDone.error().message);
  auto decoded = decodeIndex(index->payload.view, features);
  if (!decoded) return file.damaged(footer->index, "INDX: " + decoded.error().message);
  return Ending{std::move(*decoded), std::move(*decodedDone), done->header, footer->index};
}

Result<void> checkEnding(const ChunkFile& file, const Ending& ending,
                         const ChunkFile::Header& header, const Head& head) {
  const auto wrong = [&](const std::string& message) {
    return file.damaged(ending.offset, "INDX: " + message);
  };
  const Index& index = ending.index;
  if (index.fileHeader != header.bytes) {
    return wrong("its copy of the file header is different");
  }
  if (index.head != head.text) return wrong("its copy of HEAD is different");
  if (index.chunks.empty() || index.chunks.front() != head.header ||
      index.chunks.back() != ending.doneHeader) {
    return wrong("its chunks are not those from HEAD to DONE");
  }
  if (index.chunks.size() - 1 != ending.done.chunks) {
    return wrong(fmt::format("it has {} chunks before DONE, which says {}", index.chunks.size() - 1,
                             ending.done.chunks));
  }
  return {};
}

Result<std::vector<IndexRecord>> readTail(const ChunkFile& file, const ChunkFile::Header& header,
                                          const Head& head, const FileScan& scan) {
  if (!header.indexed) {
    if (scan.end == file.size()) return scan.slabs;
    return file.damaged(scan.end,
                        fmt::format("{} bytes follow the end mark of a file without index",
                                    file.size() - scan.end));
  }
  auto ending = readEnding(file, head.features);
  if (!ending) return pass(ending.error());
  if (ending->doneHeader.offset != scan.doneOffset) {
    return file.damaged(ending->doneHeader.offset, "DONE: an end mark has been before, at byte " +
                                                       std::to_string(scan.doneOffset));
  }
  if (auto checked = checkEnding(file, *ending, header, head); !checked)
    return pass(checked.error());
  const auto wrong = [&](const std::string& message) {
    return file.damaged(ending->offset, "INDX: " + message);
  };
  if (!std::ranges::equal(std::span(ending->index.chunks).subspan(1, ending->done.chunks - 1),
                          scan.chunks)) {
    return wrong("its headers of chunks are not those of the file");
  }
  const auto& said = ending->index.slabs;
  const auto [record, slab] =
      std::mismatch(said.begin(), said.end(), scan.slabs.begin(), scan.slabs.end());
  if (record != said.end()) {
    return wrong(fmt::format("record {} is not what the slab at byte {} says",
                             record - said.begin(), slab->slab));
  }
  return said;
}

}  // namespace t4d::formats
