#include "formats/t4d/head_chunk.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/metadata.h"

namespace t4d::formats {

using namespace t4d_layout;

Result<Head> readHead(const ChunkFile& file, std::uint64_t offset) {
  auto header = file.readChunkHeader(offset);
  if (!header) return header.error();
  if (header->type != kHead) {
    return file.damaged(header->offset, "the first chunk is not HEAD");
  }
  if (header->payloadBytes > kMaxHeadBytes) {
    return file.damaged(header->offset, fmt::format("HEAD has {} bytes; at most {} are allowed",
                                                    header->payloadBytes, kMaxHeadBytes));
  }
  auto payload = file.readPayload(*header);
  if (!payload) return payload.error();
  std::string text(reinterpret_cast<const char*>(payload->bytes.data()), header->payloadBytes);
  return decodeHead(file, *header, std::move(text));
}

Result<Head> decodeHead(const ChunkFile& file, const ChunkHeader& header, std::string text) {
  auto metadata = parseHead(text);
  if (!metadata) {
    const Error& error = metadata.error();
    const std::uint64_t at =
        error.offset ? header.offset + kChunkHeaderBytes + *error.offset : header.offset;
    return file.damaged(at, "HEAD: " + error.message, error.code);
  }
  const auto named = [&](std::string_view feature) {
    const auto& all = metadata->features;
    return std::find(all.begin(), all.end(), feature) != all.end();
  };
  const Features features = {named(kFeatureZstd), named(kFeatureMeans), named(kFeaturePose),
                             named(kFeatureGrid) ? metadata->grid : std::nullopt};
  return Head{std::move(*metadata), features, header, std::move(text)};
}

Result<Beginning> readBeginning(const ChunkFile& file) {
  auto header = file.readHeader();
  if (!header) return header.error();
  auto head = readHead(file);
  if (!head) return head.error();
  return Beginning{*header, std::move(*head)};
}

}  // namespace t4d::formats
