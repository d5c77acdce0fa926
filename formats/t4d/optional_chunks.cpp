#include "formats/t4d/optional_chunks.h"

#include <algorithm>

#include <fmt/format.h>

namespace t4d::formats {

using namespace t4d_layout;

bool isUnknown(ChunkType type) {
  constexpr std::array kKnown = {kHead, kConnectivity, kLayer,   kPose, kSlab,
                                 kDone, kIndex,        kPadding, kPage, kPageList};
  return std::ranges::find(kKnown, type) == kKnown.end();
}

bool isSafeToCopy(ChunkType type) {
  const auto isLower = [](char letter) { return letter >= 'a' && letter <= 'z'; };
  return isLower(type.front()) && isLower(type.back());
}

void LostChunks::add(const ChunkHeader& header) {
  auto& [count, bytes] = types_[header.name()];
  ++count;
  bytes += header.bytes();
}

std::vector<std::string> LostChunks::lines() const {
  std::vector<std::string> lines;
  for (const auto& [type, sums] : types_) {
    lines.push_back(
        fmt::format("{} {} '{}', {} bytes: by its type it is not safe to copy, so it may depend "
                    "on what has changed",
                    sums.first, sums.first == 1 ? "chunk" : "chunks", type, sums.second));
  }
  return lines;
}

Result<void> OptionalChunks::each(const Take& take) const {
  if (walk_) return walk_(take);
  for (const ChunkHeader& header : headers_) {
    if (auto taken = take(*file_, header); !taken) return taken;
  }
  return {};
}

Result<void> copyOptionalChunks(const OptionalChunks& chunks, ChunkWriter& into, LostChunks& lost) {
  return chunks.each([&](const ChunkFile& file, const ChunkHeader& header) -> Result<void> {
    if (header.critical()) {
      return file.damaged(
          header.offset,
          fmt::format("the chunk '{}' is needed, but this version does not know it; a newer t4d "
                      "may",
                      header.name()),
          ErrorCode::Unsupported);
    }
    if (!isSafeToCopy(header.type)) {
      lost.add(header);
      return {};
    }
    const auto chunk = file.readChunk(header.offset, header.type);
    if (!chunk) return chunk.error();
    if (auto put = into.putCopy(header, chunk->payload.bytes); !put) return put.error();
    return {};
  });
}

}  // namespace t4d::formats
