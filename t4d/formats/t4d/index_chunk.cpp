#include "t4d/formats/t4d/index_chunk.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include <fmt/format.h>

#include "t4d/formats/t4d/chunk_fields.h"

namespace t4d::formats {

using model::Point4;
using model::ScalarType;
using t4d_layout::Features;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadView;
using t4d_layout::PayloadWriter;

SlabExtent extentOf(const model::Slab& slab) {
  SlabExtent extent;
  extent.cells = slab.connectivity->cells.size();
  for (const Point4& vertex : slab.vertices) extent.bounds.add(vertex.head<3>());
  return extent;
}

namespace {

/// An array with a row for each of `records`, of which `numbersOf` gives an array.
template <class NumbersOf>
void putColumn(PayloadWriter& into, std::span<const IndexRecord> records, int level,
               NumbersOf numbersOf) {
  using Numbers = decltype(numbersOf(records[0]));
  std::vector<typename Numbers::value_type> all;
  for (const IndexRecord& record : records) {
    const Numbers row = numbersOf(record);
    all.insert(all.end(), row.begin(), row.end());
  }
  ArrayView view = viewOf(all);
  view.components = std::tuple_size_v<Numbers>;
  putArray(into, view, level);
}

/// The rows of such an array, which must be as many as there are records; `set` takes each of them.
template <class Number, std::size_t kComponents, class Set>
Result<void> takeColumn(PayloadReader& from, std::span<IndexRecord> records,
                        const Features& features, Set set) {
  const auto array = takeArrayOf(from, model::scalarTypeOf<Number>(), kComponents, features);
  if (!array) return pass(array.error());
  if (array->rows != records.size()) {
    return invalid(fmt::format("it has {} slabs, and {} rows of what it says of them",
                               records.size(), array->rows));
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    std::array<Number, kComponents> row;
    std::memcpy(row.data(), array->bytes.data() + i * sizeof row, sizeof row);
    set(records[i], row);
  }
  return {};
}

/// Reads the directory of chunks.
Result<std::vector<ChunkHeader>> takeHeaders(PayloadReader& from, const Features& features) {
  const auto array =
      takeArrayOf(from, ScalarType::UInt8, t4d_layout::kDirectoryEntryBytes, features);
  if (!array) return pass(array.error());
  std::vector<ChunkHeader> headers;
  std::uint64_t offset = t4d_layout::kFileHeaderBytes;
  headers.reserve(array->rows);
  for (std::size_t i = 0; i < array->rows; ++i) {
    const auto bytes = std::span(array->bytes)
                           .subspan(i * t4d_layout::kDirectoryEntryBytes)
                           .first<t4d_layout::kDirectoryEntryBytes>();
    const ChunkHeader header = decodeChunkHeader(bytes, offset);
    constexpr std::uint64_t kMost = std::uint64_t{1} << 62U;  // so that no sum overflows
    if (header.payloadBytes > kMost || offset > kMost) {
      return invalid(
          fmt::format("the header of chunk {} says that it has {} bytes", i, header.payloadBytes));
    }
    offset = header.end();
    headers.push_back(header);
  }
  return headers;
}

/// Sets place and size of each slab, which is to be one of the chunks, as are its parts.
Result<void> placeSlabs(const std::vector<ChunkHeader>& chunks, std::span<IndexRecord> records) {
  std::size_t next = 0;
  for (const ChunkHeader& chunk : chunks) {
    if (chunk.type != t4d_layout::kSlab) continue;
    if (next < records.size()) {
      records[next].slab = chunk.offset;
      records[next].slabBytes = chunk.bytes();
    }
    ++next;
  }
  if (next != records.size()) {
    return invalid(fmt::format("it says that there are {} slabs, of which {} are among its chunks",
                               records.size(), next));
  }
  const auto isOf = [&](std::uint64_t offset, t4d_layout::ChunkType type) {
    const auto chunk = std::ranges::lower_bound(chunks, offset, {}, &ChunkHeader::offset);
    return chunk != chunks.end() && chunk->offset == offset && chunk->type == type;
  };
  const auto isLayer = [&](std::uint64_t offset) {
    return offset == 0 || isOf(offset, t4d_layout::kLayer) || isOf(offset, t4d_layout::kPose);
  };
  for (const IndexRecord& record : records) {
    if (!isOf(record.connectivity(), t4d_layout::kConnectivity) || !isLayer(record.lower()) ||
        !isLayer(record.upper())) {
      return invalid(fmt::format("the slab at byte {} has a connectivity or a layer that is none",
                                 record.slab));
    }
  }
  return {};
}

}  // namespace

PayloadWriter encodeIndex(const Index& index, int level) {
  PayloadWriter payload;
  payload.putBytes(index.fileHeader.data(), index.fileHeader.size());
  payload.put(static_cast<std::uint32_t>(index.slabs.size()));
  putArray(payload, {ScalarType::UInt8, 1, std::as_bytes(std::span(index.head))}, 0);
  std::vector<std::byte> headers;
  for (const ChunkHeader& chunk : index.chunks) {
    const ChunkHeaderBytes bytes = encodeChunkHeader(chunk);
    headers.insert(headers.end(), bytes.begin(), bytes.begin() + t4d_layout::kDirectoryEntryBytes);
  }
  putArray(payload, {ScalarType::UInt8, t4d_layout::kDirectoryEntryBytes, headers}, level);
  putColumn(payload, index.slabs, level, [](const IndexRecord& slab) {
    return std::array{slab.time.begin, slab.time.end};
  });
  putColumn(payload, index.slabs, level, [](const IndexRecord& slab) {
    return std::array{slab.parts.connectivity, slab.parts.lower, slab.parts.upper};
  });
  putColumn(payload, index.slabs, level,
            [](const IndexRecord& slab) { return std::array{slab.parts.body}; });
  putColumn(payload, index.slabs, level,
            [](const IndexRecord& slab) { return std::array{slab.extent->cells}; });
  putColumn(payload, index.slabs, level, [](const IndexRecord& slab) {
    const auto& [min, max] = slab.extent->bounds;
    return std::array{min[0], min[1], min[2], max[0], max[1], max[2]};
  });
  return payload;
}

Result<Index> decodeIndex(const PayloadView& payload, const Features& features) {
  PayloadReader from(payload);
  Index index;
  const auto fileHeader = from.takeBytes(index.fileHeader.size());
  const auto slabs = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("the index");
  std::copy(fileHeader.begin(), fileHeader.end(), index.fileHeader.begin());
  const auto packedHead = takePacked(from, {});
  if (!packedHead) return pass(packedHead.error());
  if (packedHead->type != ScalarType::UInt8 || packedHead->components != 1 ||
      packedHead->codec != Codec::Raw) {
    return invalid("its copy of HEAD is not bytes as they are");
  }
  const auto head = unpack(*packedHead);
  if (!head) return pass(head.error());
  index.head.assign(reinterpret_cast<const char*>(head->data()), head->size());
  auto headers = takeHeaders(from, features);
  if (!headers) return pass(headers.error());
  index.chunks = std::move(*headers);
  if (slabs > index.chunks.size()) {
    return invalid(
        fmt::format("it says that there are {} slabs among {} chunks", slabs, index.chunks.size()));
  }
  index.slabs.resize(slabs);
  const std::span all(index.slabs);
  for (IndexRecord& slab : all) slab.extent.emplace();
  auto taken = takeColumn<double, 2>(from, all, features, [](IndexRecord& slab, const auto& row) {
    slab.time = {row[0], row[1]};
  });
  if (taken) {
    taken = takeColumn<std::uint64_t, 3>(from, all, features, [](auto& slab, const auto& row) {
      slab.parts.connectivity = row[0];
      slab.parts.lower = row[1];
      slab.parts.upper = row[2];
    });
  }
  if (taken) {
    taken = takeColumn<std::uint32_t, 1>(
        from, all, features, [](auto& slab, const auto& row) { slab.parts.body = row[0]; });
  }
  if (taken) {
    taken = takeColumn<std::uint64_t, 1>(
        from, all, features, [](auto& slab, const auto& row) { slab.extent->cells = row[0]; });
  }
  if (taken) {
    taken = takeColumn<double, 6>(from, all, features, [](auto& slab, const auto& row) {
      slab.extent->bounds.min = {row[0], row[1], row[2]};
      slab.extent->bounds.max = {row[3], row[4], row[5]};
    });
  }
  if (taken) taken = checkEnd(from);
  if (taken) taken = placeSlabs(index.chunks, all);
  if (!taken) return pass(taken.error());
  for (const IndexRecord& slab : all) {
    if (auto checked = checkTime(slab.time); !checked) {
      return invalid(fmt::format("the slab at byte {}: {}", slab.slab, checked.error().message));
    }
  }
  return index;
}

}  // namespace t4d::formats
