#pragma once

#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Judges slab records, in file order, against each other and the file: parts before their slab,
/// slabs of a body in time order, each lower layer the upper layer of the slab before.
class RecordJudge {
 public:
  RecordJudge(const ChunkFile& file, std::size_t bodyCount) : file_(file), last_(bodyCount) {}
  Result<void> add(const IndexRecord& record);

 private:
  const ChunkFile& file_;
  std::vector<std::optional<IndexRecord>> last_;  // of each body
  std::uint64_t before_ = 0;
};

/// The end mark says of each body as many slabs and the times that `records` have.
Result<void> checkDone(const Done& done, const std::vector<IndexRecord>& records,
                       std::size_t bodyCount);

/// What reading a file from the front finds.
struct FileScan {
  std::vector<IndexRecord> slabs;
  std::optional<Done> done;  ///< none where the file ends before it
  std::uint64_t doneOffset = 0;
  std::uint64_t end = 0;        ///< of the last whole chunk
  std::optional<Error> damage;  ///< what ended the reading early
};

/// Reads chunk after chunk from the one after HEAD to DONE, each with its checksum, and judges that
/// they are in an order that a reader can follow.
FileScan scanFile(ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  t4d_layout::Features features, const model::Progress& progress = {});

}  // namespace t4d::formats
