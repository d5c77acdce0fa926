#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "formats/t4d/layout.h"
#include "t4d/file.h"

namespace t4d::formats {

inline void addChunk(std::vector<T4dChunks>& chunks, t4d_layout::ChunkType type,
                     std::uint64_t bytes) {
  const std::string name(type.begin(), type.end());
  auto found = std::ranges::find(chunks, name, &T4dChunks::type);
  if (found == chunks.end()) found = chunks.insert(found, {name, 0, 0});
  ++found->count;
  found->bytes += bytes;
}

}  // namespace t4d::formats
