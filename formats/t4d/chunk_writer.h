#pragma once

#include <span>
#include <string>
#include <vector>

#include "formats/output_file.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/pages.h"

namespace t4d::formats {

/// Writes the chunks of a .t4d file one after another, and what is around them: the file header
/// before, DONE, index and footer after them.
class ChunkWriter {
 public:
  /// `level` is that of zstd for the index.
  /// `pageSlabs` slabs are in a page of the index, which files of many slabs have.
  ChunkWriter(OutputFile out, bool indexed, int level, std::size_t pageSlabs = kUsualPageSlabs)
      : out_(std::move(out)), indexed_(indexed), level_(level), pageSlabs_(pageSlabs) {}

  /// Writes the file header and HEAD.
  Result<void> begin(const std::string& head, std::uint16_t minorVersion);
  bool begun() const { return !chunks_.empty(); }

  /// These return the offset of the chunk.
  Result<std::uint64_t> put(t4d_layout::ChunkType type, const t4d_layout::PayloadWriter& payload,
                            std::uint32_t flags = t4d_layout::kFlagCritical);
  /// A chunk of another file; its payload with the padding.
  Result<std::uint64_t> putCopy(ChunkHeader header, std::span<const std::byte> payload);

  /// Adds the record of a slab to the index, in the order of the file.
  void addSlab(const IndexRecord& record) {
    if (indexed_) slabs_.push_back(record);
  }
  /// Bytes so far, the offset of the next chunk.
  std::uint64_t size() const { return out_.size(); }

  /// Writes DONE, and index and footer if the file has them; then moves it to its path. Returns its
  /// size in bytes.
  Result<std::uint64_t> finish(const std::vector<BodySummary>& bodies);

 private:
  Result<void> writePadded(std::span<const std::byte> bytes);
  Result<void> putPages(std::size_t bodyCount);
  Result<void> raiseVersion();
  Result<void> putIndexAndFooter(std::uint64_t doneOffset);

  OutputFile out_;
  bool indexed_;
  int level_;
  std::size_t pageSlabs_;
  IndexFront front_;
  ChunkList chunks_;
  SlabList slabs_;  // none without an index
};

}  // namespace t4d::formats
