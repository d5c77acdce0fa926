#include "formats/t4d/ending.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/pages.h"

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
  if (!footer) return footer.error();
  auto done = readNamed(file, footer->done, kDone);
  if (!done) return done.error();
  auto index = readNamed(file, footer->index, kIndex);
  if (!index) return index.error();
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

namespace {

/// Reads the ending of a file with pages: nothing of the index need be in memory at once.
Result<SlabList> readPagedTail(const ChunkFile& file, const ChunkFile::Header& header,
                               const Head& head, const FileScan& scan, const PageList& pages) {
  auto slabs = checkPages(file, pages, scan.chunks, scan.slabs, head.features);
  if (!slabs) return slabs;
  const auto footer = file.readFooter();
  if (!footer) return footer.error();
  const auto done = file.readChunkHeader(scan.doneOffset);
  if (!done) return done.error();
  if (footer->done != done->offset || footer->index != done->end()) {
    return file.damaged(file.size() - kFooterBytes, "the footer is that of another end mark");
  }
  const auto index = file.readChunk(footer->index, kIndex);
  if (!index) return index.error();
  if (index->header.end() != file.size() - kFooterBytes) {
    return file.damaged(index->header.end(), "the footer does not follow the index at once");
  }
  if (checksumOf(index->header) != footer->indexChecksum) {
    return file.damaged(file.size() - kFooterBytes, "the footer is that of another index");
  }
  ChunkList chunks;
  chunks.push_back(head.header);
  for (const ChunkHeader& chunk : scan.chunks.all()) chunks.push_back(chunk);
  chunks.push_back(*done);
  auto same = compareIndex(index->payload.view, head.features, {header.bytes, head.text},
                           chunks.rows(), slabs->rows());
  if (!same) return file.damaged(footer->index, "INDX: " + same.error().message);
  return slabs;
}

Result<SlabList> readIndexedTail(const ChunkFile& file, const ChunkFile::Header& header,
                                 const Head& head, const FileScan& scan) {
  auto ending = readEnding(file, head.features);
  if (!ending) return ending.error();
  if (ending->doneHeader.offset != scan.doneOffset) {
    return file.damaged(ending->doneHeader.offset, "DONE: an end mark has been before, at byte " +
                                                       std::to_string(scan.doneOffset));
  }
  if (auto checked = checkEnding(file, *ending, header, head); !checked) return checked.error();
  const auto wrong = [&](const std::string& message) {
    return file.damaged(ending->offset, "INDX: " + message);
  };
  if (!std::ranges::equal(std::span(ending->index.chunks).subspan(1, ending->done.chunks - 1),
                          scan.chunks.all())) {
    return wrong("its headers of chunks are not those of the file");
  }
  // There are as many, for there are as many SLABs among the chunks.
  SlabList slabs;
  for (const IndexRecord& said : ending->index.slabs) {
    const IndexRecord found = scan.slabs[slabs.size()];
    if (!(said == found)) {
      return wrong(
          fmt::format("record {} is not what the slab at byte {} says", slabs.size(), found.slab));
    }
    slabs.push_back(said);
  }
  return slabs;
}

}  // namespace

Result<SlabList> readTail(const ChunkFile& file, const ChunkFile::Header& header, const Head& head,
                          const FileScan& scan, bool canGoBack) {
  if (!header.indexed) {
    if (scan.end != file.size()) {
      return file.damaged(scan.end,
                          fmt::format("{} bytes follow the end mark of a file without index",
                                      file.size() - scan.end));
    }
    SlabList slabs;
    for (const IndexRecord& slab : scan.slabs.all()) slabs.push_back(slab);
    return slabs;
  }
  if (canGoBack) {
    const auto pages = readPageList(file, scan.doneOffset, scan.done->bodies);
    if (!pages) return pages.error();
    if (*pages) return readPagedTail(file, header, head, scan, **pages);
    for (const ChunkHeader& chunk : scan.chunks.all()) {
      if (chunk.type == kPage) return file.damaged(chunk.offset, "PAGE: no PGIX is before DONE");
    }
  }
  return readIndexedTail(file, header, head, scan);
}

}  // namespace t4d::formats
