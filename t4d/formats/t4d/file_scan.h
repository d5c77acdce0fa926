#pragma once

#include <initializer_list>
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
  /// The parts that a chunk at `offset` may name, but for upper layers of the last slabs, which the
  /// next ones may; call with increasing offsets.
  const PartWindow& windowAt(std::uint64_t offset);
  /// Offsets of those upper layers.
  std::vector<std::uint64_t> lastUppers() const;

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
class FileScanner {
 public:
  FileScanner(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
              const t4d_layout::Features& features);
  FileScanner(const FileScanner&) = delete;
  FileScanner& operator=(const FileScanner&) = delete;

  /// Reads the next chunk; call until done() is true. After an error there is no next.
  Result<ChunkHeader> next();
  bool done() const { return scan_.done.has_value(); }
  const FileScan& scan() const { return scan_; }
  FileScan take() { return std::move(scan_); }

  /// Offsets of the parts that slabs to come may need, in order.
  std::vector<std::uint64_t> neededParts();

 private:
  /// A chunk that slabs refer to.
  struct Part {
    std::uint64_t offset = 0;
    t4d_layout::ChunkType type{};
    std::uint64_t layer = 0;  ///< that a POSE moves
    bool named = false;       ///< referred to by a slab, or by a POSE
  };

  Result<void> take(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  Result<void> takePose(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  Result<void> takeSlab(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  /// The part at `offset`, or the end.
  std::vector<Part>::iterator find(std::uint64_t offset);
  /// Records that something refers to the part at `offset`; false if there is none of these types.
  bool name(std::uint64_t offset, std::initializer_list<t4d_layout::ChunkType> types);
  Result<void> checkAllNamed() const;

  const ChunkFile& file_;
  std::size_t bodyCount_;
  t4d_layout::Features features_;
  FileScan scan_;
  RecordChecker checker_;
  std::uint64_t chunks_ = 0;
  std::vector<Part> parts_;  // offsets increase
};

/// Reads all of them, or up to the first damage.
FileScan scanFile(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  const t4d_layout::Features& features, const model::Progress& progress = {});

}  // namespace t4d::formats
