#pragma once

#include <optional>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/formats/t4d/part_window.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Checks slab records, in file order, against each other and the file: parts precede their slab
/// and are not too many chunks before it, slabs of a body are in time order, and each lower layer
/// is the upper layer of the slab before, or a copy of it.
class RecordChecker {
 public:
  /// `chunks` are those of the file, at least all before a record that is added.
  RecordChecker(const ChunkFile& file, std::size_t bodyCount,
                const std::vector<ChunkHeader>& chunks)
      : file_(file), chunks_(chunks), window_(bodyCount), last_(bodyCount) {}
  Result<void> add(const IndexRecord& record);
  /// The parts that a chunk at `offset` may name; call with increasing offsets.
  const PartWindow& windowAt(std::uint64_t offset);

 private:
  bool areCopies(std::uint64_t layer, std::uint64_t other) const;

  const ChunkFile& file_;
  const std::vector<ChunkHeader>& chunks_;
  std::size_t next_ = 0;  // of the chunks that are not in the window yet
  PartWindow window_;
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
