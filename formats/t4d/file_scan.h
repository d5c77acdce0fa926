#pragma once

#include <initializer_list>
#include <optional>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/part_window.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Checks slab records, in file order, against each other and the file: parts precede their slab
/// and are not too many chunks before it, slabs of a body are in time order, and each lower layer
/// is the upper layer of the slab before, or a copy of it.
class RecordChecker {
 public:
  RecordChecker(const ChunkFile& file, std::size_t bodyCount)
      : file_(file), window_(bodyCount), last_(bodyCount) {}
  /// Call in file order, with each chunk; and with the record of a slab before its chunk.
  void addChunk(const ChunkHeader& chunk) { window_.add(chunk); }
  Result<void> add(const IndexRecord& record);
  /// The parts that the next chunk may refer to, except for upper layers of the last slabs, which
  /// the next slabs may.
  const PartWindow& window() const { return window_; }
  /// The upper layers of the last slabs.
  std::vector<ChunkHeader> lastUppers() const;

 private:
  /// A slab, and its upper layer, if that is one of the file.
  struct Last {
    IndexRecord record;
    ChunkHeader upper;
  };
  bool isCopy(std::uint64_t layer, const ChunkHeader& of) const;

  const ChunkFile& file_;
  PartWindow window_;
  std::vector<std::optional<Last>> last_;  // per body
  std::uint64_t before_ = 0;
};

/// The number of slabs of a body that were found, and their times.
struct BodySpan {
  std::uint64_t slabs = 0;
  model::TimeSpan time;

  void add(const model::TimeSpan& slab) {
    if (slabs++ == 0) time.begin = slab.begin;
    time.end = slab.end;
  }
};

/// Checks that the end mark gives, for each body, the number of slabs and the times in `found`.
Result<void> checkDone(const Done& done, const std::vector<BodySpan>& found);

/// The contents found by reading a file from the front.
struct FileScan {
  ChunkList chunks;  ///< without HEAD and DONE
  SlabList slabs;
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

  /// The parts that slabs to come may need, in order.
  std::vector<ChunkHeader> neededParts() const;

 private:
  /// A chunk that slabs refer to.
  struct Part {
    ChunkHeader header;
    std::uint64_t layer = 0;  ///< that a POSE moves
    bool named = false;       ///< referred to by a slab, or by a POSE
  };

  Result<void> take(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  Result<void> takePose(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  Result<void> takeSlab(const ChunkHeader& header, const t4d_layout::PayloadView& payload);
  /// The part at `offset`, or null.
  const Part* find(std::uint64_t offset) const;
  void forgetParts();
  /// Records that something refers to the part at `offset`; false if there is none of these types.
  bool name(std::uint64_t offset, std::initializer_list<t4d_layout::ChunkType> types);
  Result<void> checkAllNamed() const;

  const ChunkFile& file_;
  t4d_layout::Features features_;
  FileScan scan_;
  RecordChecker checker_;
  std::uint64_t chunks_ = 0;
  std::vector<Part> parts_;  // offsets increase; without those that nothing to come may name
  std::size_t forgetAt_ = 1024;
  std::vector<BodySpan> found_;  // of the bodies
};

/// Reads all of them, or up to the first damage.
FileScan scanFile(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  const t4d_layout::Features& features, const model::Progress& progress = {});

}  // namespace t4d::formats
