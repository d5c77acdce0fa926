#pragma once

#include "formats/t4d/chunk_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// HEAD, the first chunk.
struct Head {
  Metadata metadata;
  t4d_layout::Features features;
  ChunkHeader header;
  std::string text;  ///< the payload
};

Result<Head> readHead(const ChunkFile& file, std::uint64_t offset = t4d_layout::kFileHeaderBytes);

/// Parses HEAD from a copy of the chunk's header and its payload.
Result<Head> decodeHead(const ChunkFile& file, const ChunkHeader& header, std::string text);

/// File header and HEAD.
struct Beginning {
  ChunkFile::Header header;
  Head head;
};
Result<Beginning> readBeginning(const ChunkFile& file);

}  // namespace t4d::formats
