#include "conformance/corpus/slice_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <span>

#include <fmt/format.h>

#include "formats/t4d/chunk_list.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/layout.h"

namespace t4d::conformance {
namespace {

using namespace formats::t4d_layout;
using formats::ChunkHeader;
using formats::listChunks;

/// The slab in which a body is sliced at a time (SPEC.md, X2).
std::optional<formats::IndexRecord> slabFor(const std::vector<formats::IndexRecord>& records,
                                            std::uint32_t body, double time) {
  double last = 0;
  for (const formats::IndexRecord& record : records) {
    if (record.parts.body == body) last = record.time.end;
  }
  for (const formats::IndexRecord& record : records) {
    if (record.parts.body != body) continue;
    const bool reaches = time == last ? record.time.end == time : record.time.end > time;
    if (reaches) return record.time.begin <= time ? std::optional(record) : std::nullopt;
  }
  return std::nullopt;
}

/// The records of the slabs in INDX. Fails if the file has no index or is invalid.
Result<std::vector<formats::IndexRecord>> recordsOf(const std::string& bytes) {
  const std::vector<ChunkHeader> chunks = listChunks(bytes);
  const auto index = std::ranges::find(chunks, kIndex, &ChunkHeader::type);
  if (index == chunks.end()) return invalid("the file has no INDX");
  const auto payload = formats::payloadOf(
      *index, std::as_bytes(std::span(bytes)).subspan(index->payload(), index->payloadBytes));
  if (!payload) return payload.error();
  auto decoded = formats::decodeIndex(*payload);
  if (!decoded) return decoded.error();
  return std::move(decoded->slabs);
}

}  // namespace

Result<SliceParts> partsForSlice(const std::string& bytes, double time) {
  const auto records = recordsOf(bytes);
  if (!records) return records.error();
  std::set<std::uint64_t> needed;
  std::set<std::uint32_t> bodies;
  for (const formats::IndexRecord& record : *records) bodies.insert(record.parts.body);
  for (const std::uint32_t body : bodies) {
    const auto slab = slabFor(*records, body, time);
    if (!slab) continue;
    needed.insert({slab->slab, slab->connectivity(), slab->lower(), slab->upper()});
  }
  SliceParts parts;
  const std::vector<ChunkHeader> chunks = listChunks(bytes);
  for (const ChunkHeader& chunk : chunks) {
    if (chunk.type != kPose || !needed.contains(chunk.offset)) continue;
    constexpr std::size_t kLayerInPose = 8;
    std::uint64_t distance = 0;
    std::memcpy(&distance, bytes.data() + chunk.fields() + kLayerInPose, sizeof distance);
    needed.insert(chunk.offset - distance);
  }
  for (const ChunkHeader& chunk : chunks) {
    const Part part = {fmt::format("{} at byte {}", chunk.name(), chunk.offset), chunk.offset,
                       chunk.end() - chunk.offset};
    const bool data = chunk.type == kSlab || chunk.type == kConnectivity || chunk.type == kLayer ||
                      chunk.type == kPose;
    const bool always = chunk.type == kDone || chunk.type == kIndex;
    if (always || needed.contains(chunk.offset)) {
      parts.read.push_back(part);
    } else if (data) {
      parts.unneeded.push_back(part);
    }
  }
  parts.read.push_back({"the footer", bytes.size() - kFooterBytes, kFooterBytes});
  return parts;
}

std::optional<double> timeThatReads(const std::string& bytes, std::uint64_t offset) {
  const auto records = recordsOf(bytes);
  if (!records) return std::nullopt;
  for (const formats::IndexRecord& record : *records) {
    const double middle = record.time.begin + (record.time.end - record.time.begin) / 2;
    const auto parts = partsForSlice(bytes, middle);
    const auto holds = [&](const Part& part) {
      return part.offset <= offset && offset < part.offset + part.size;
    };
    if (std::isfinite(middle) && parts && std::ranges::any_of(parts->read, holds)) return middle;
  }
  return std::nullopt;
}

}  // namespace t4d::conformance
