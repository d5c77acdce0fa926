#pragma once

#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Checks slab records, in file order, against each other and the file: parts precede their slab,
/// slabs of a body are in time order, and each lower layer is the upper layer of the slab before.
class RecordChecker {
 public:
  RecordChecker(const ChunkFile& file, std::size_t bodyCount) : file_(file), last_(bodyCount) {}
  Result<void> add(const IndexRecord& record);

 private:
  const ChunkFile& file_;
  std::vector<std::optional<IndexRecord>> last_;  // per body
  std::uint64_t before_ = 0;
};

/// Checks that the end mark gives, for each body, the number of slabs and the times in `records`.
Result<void> checkDone(const Done& done, const std::vector<IndexRecord>& records,
                       std::size_t bodyCount);

/// What was found by reading a file from the front.
struct FileScan {
  std::vector<ChunkHeader> chunks;  ///< without HEAD and DONE
  std::vector<IndexRecord> slabs;
  std::optional<Done> done;  ///< empty if the file ends before it
  std::uint64_t doneOffset = 0;
  std::uint64_t end = 0;        ///< end of the last complete chunk
  std::optional<Error> damage;  ///< why reading stopped early
};

/// Reads the chunks from the one after HEAD to DONE, verifies each checksum, and checks that a
/// reader can follow them in this order.
FileScan scanFile(ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  t4d_layout::Features features, const model::Progress& progress = {});

}  // namespace t4d::formats
