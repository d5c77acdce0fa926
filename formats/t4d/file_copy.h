#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <ranges>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunk_writer.h"
#include "formats/t4d/head_chunk.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/optional_chunks.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

/// Files whose chunks become part of another file as they are.
namespace t4d::formats {

/// The places of the chunks and the slabs of some files, one file after another.
struct CopiedChunks {
  ChunkList chunks;  ///< those between HEAD and DONE
  SlabList slabs;    ///< all have an extent
};

/// Rows of such a list.
struct CopiedRange {
  std::size_t first = 0;
  std::size_t count = 0;

  template <class List>
  auto of(const List& list) const {
    return list.all() | std::views::drop(first) | std::views::take(count);
  }
};

/// A file to be copied, with all its chunks checked.
struct CopiedFile {
  std::filesystem::path path;
  Head head;
  CopiedRange chunks;
  CopiedRange slabs;
  std::vector<BodySummary> bodies;
  std::vector<T4dChunks> sums;  ///< of all its chunks

  const Metadata& metadata() const { return head.metadata; }
};

/// Reads a file through, as T4dReader does with T4dOpen::Checked, and checks DONE against what the
/// index, or the slabs without one, say of the slabs. Appends what it has to `into`.
Result<CopiedFile> readForCopy(const std::filesystem::path& path, CopiedChunks& into,
                               const model::Progress& progress = {});

/// Reads only HEAD, DONE and the index, of a file that has an index and was checked before. Leaves
/// `sums` empty.
Result<CopiedFile> readIndexForCopy(const std::filesystem::path& path, CopiedChunks& into);

/// An attribute that both files describe, in different ways; nothing if there is none.
std::optional<std::string> differingAttribute(const Metadata& one, const Metadata& other);

/// The chunks that were copied or left out of the files so far.
struct CopyState {
  std::set<std::string> kept = {};  ///< headers of unknown chunks that are copied, each once
  LostChunks lost = {};
};

/// Stores a chunk in the other file; `slab` is the record of a SLAB, and null for other chunks.
using PutChunk = std::function<Result<void>(ChunkFile::Chunk& chunk, const IndexRecord* slab)>;

/// Reads a chunk that is to be copied, whose header is known.
Result<ChunkFile::Chunk> readForCopy(const ChunkFile& from, const ChunkHeader& known);

/// Gives the chunks between HEAD and DONE to `put`, one at a time, without those that may not be
/// copied and without pages of the index; calls `one` after each. `file` is `from`, opened, and
/// `all` has its chunks.
Result<void> copyChunks(const ChunkFile& file, const CopiedFile& from, const CopiedChunks& all,
                        const PutChunk& put, CopyState& state,
                        const std::function<Result<void>()>& one);

/// HEAD of a file into which others are copied.
struct CopyHead {
  std::string text;
  bool zstd = false;
};
/// Makes HEAD of a copy, with the features of all files.
Result<CopyHead> headOfCopy(const Metadata& metadata, std::span<const CopiedFile> files);

/// Starts the file at `into`, with that HEAD.
Result<ChunkWriter> beginCopy(const std::filesystem::path& into, const Metadata& metadata,
                              std::span<const CopiedFile> files);

}  // namespace t4d::formats
