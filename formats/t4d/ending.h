#pragma once

#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/file_scan.h"
#include "formats/t4d/head_chunk.h"
#include "formats/t4d/index_chunk.h"

namespace t4d::formats {

/// The index and end mark of an indexed file.
struct Ending {
  Index index;
  Done done;
  ChunkHeader doneHeader;
  std::uint64_t offset = 0;  // of the index
};

Result<Ending> readEnding(const ChunkFile& file, const t4d_layout::Features& features);

/// Checks the index against file header, HEAD and DONE.
Result<void> checkEnding(const ChunkFile& file, const Ending& ending,
                         const ChunkFile::Header& header, const Head& head);

/// The slabs, after checking that the end mark is followed by an index that agrees with `scan` and
/// a footer, or by nothing. With an index they have their contents from it. With `canGoBack` its
/// pages are checked as well.
Result<SlabList> readTail(const ChunkFile& file, const ChunkFile::Header& header, const Head& head,
                          const FileScan& scan, bool canGoBack = true);

}  // namespace t4d::formats
