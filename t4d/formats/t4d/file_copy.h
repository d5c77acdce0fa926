#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunk_writer.h"
#include "t4d/formats/t4d/head_chunk.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/formats/t4d/optional_chunks.h"
#include "t4d/model/slab.h"

/// Files whose chunks become part of another file as they are.
namespace t4d::formats {

/// A file to be copied, with all its chunks checked.
struct CopiedFile {
  std::filesystem::path path;
  Head head;
  std::vector<ChunkHeader> chunks;  ///< between HEAD and DONE
  std::vector<IndexRecord> slabs;   ///< all have an extent
  std::vector<BodySummary> bodies;

  const Metadata& metadata() const { return head.metadata; }
};

/// Reads a file through, as T4dReader does with T4dOpen::Checked, and checks DONE against what the
/// index, or the slabs without one, say of the slabs.
Result<CopiedFile> readForCopy(const std::filesystem::path& path,
                               const model::Progress& progress = {});

/// An attribute that both files describe, in different ways; nothing if there is none.
std::optional<std::string> differingAttribute(const Metadata& one, const Metadata& other);

/// What was copied or left out of the files so far.
struct CopyState {
  std::set<std::string> kept = {};  ///< headers of unknown chunks that are copied, each once
  LostChunks lost = {};
};

/// Stores a chunk in the other file; `slab` is the record of a SLAB, and null for other chunks.
using PutChunk = std::function<Result<void>(ChunkFile::Chunk& chunk, const IndexRecord* slab)>;

/// Gives the chunks between HEAD and DONE to `put`, one at a time, without those that may not be
/// copied; calls `one` after each. `file` is `from`, opened.
Result<void> copyChunks(ChunkFile& file, const CopiedFile& from, const PutChunk& put,
                        CopyState& state, const std::function<void()>& one);

/// Starts the file at `into`, with the features of all files.
Result<ChunkWriter> beginCopy(const std::filesystem::path& into, const Metadata& metadata,
                              std::span<const CopiedFile> files);

}  // namespace t4d::formats
