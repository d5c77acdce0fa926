#include "formats/t4d/index_chunk.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include <fmt/format.h>

#include "formats/t4d/chunk_fields.h"

namespace t4d::formats {

using model::Point4;
using model::ScalarType;
using t4d_layout::Features;
using t4d_layout::kBlockRows;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadView;
using t4d_layout::PayloadWriter;

PlainRecord::PlainRecord(const IndexRecord& record)
    : slab(record.slab),
      slabBytes(record.slabBytes),
      parts(record.parts),
      time(record.time),
      hasExtent(record.extent.has_value()) {
  if (!hasExtent) return;
  const auto& [min, max] = record.extent->bounds;
  cells = record.extent->cells;
  bounds = {min[0], min[1], min[2], max[0], max[1], max[2]};
}

PlainRecord::operator IndexRecord() const {
  IndexRecord record{slab, slabBytes, parts, time};
  if (hasExtent) {
    const auto& [a, b, c, d, e, f] = bounds;
    record.extent = {cells, {{a, b, c}, {d, e, f}}};
  }
  return record;
}

SlabExtent extentOf(const model::Slab& slab) {
  SlabExtent extent;
  extent.cells = slab.connectivity->cells.size();
  for (const Point4& vertex : slab.vertices) extent.bounds.add(vertex.head<3>());
  return extent;
}

namespace {

/// The array of what `numbersOf` gives for each row.
template <class Row, class NumbersOf>
MadeArray columnOf(const Rows<Row>& rows, NumbersOf numbersOf) {
  using Numbers = decltype(numbersOf(Row()));
  const auto make = [&rows, numbersOf](std::uint64_t first, std::span<std::byte> into) {
    constexpr std::size_t kAtOnce = 4096;
    std::vector<Row> some;
    for (; !into.empty(); first += some.size()) {
      some.resize(std::min(kAtOnce, into.size() / sizeof(Numbers)));
      rows.read(first, some);
      for (const Row& row : some) {
        const Numbers numbers = numbersOf(row);
        std::memcpy(into.data(), numbers.data(), sizeof numbers);
        into = into.subspan(sizeof numbers);
      }
    }
  };
  return {model::scalarTypeOf<typename Numbers::value_type>(), std::tuple_size_v<Numbers>,
          rows.count, make};
}

MadeArray columnOfHeaders(const Rows<ChunkHeader>& chunks) {
  return columnOf(chunks, [](const ChunkHeader& chunk) {
    std::array<std::uint8_t, t4d_layout::kDirectoryEntryBytes> numbers{};
    const ChunkHeaderBytes bytes = encodeChunkHeader(chunk);
    std::memcpy(numbers.data(), bytes.data(), numbers.size());
    return numbers;
  });
}

/// Calls `use` with each array of what INDX says of the slabs, up to the first error.
template <class Use>
Result<void> eachColumn(const Rows<IndexRecord>& slabs, Use use) {
  auto used = use(columnOf(slabs, [](const IndexRecord& slab) {
    return std::array{slab.time.begin, slab.time.end};
  }));
  if (used) {
    used = use(columnOf(slabs, [](const IndexRecord& slab) {
      return std::array{slab.parts.connectivity, slab.parts.lower, slab.parts.upper};
    }));
  }
  if (used) {
    used =
        use(columnOf(slabs, [](const IndexRecord& slab) { return std::array{slab.parts.body}; }));
  }
  if (used) {
    used = use(
        columnOf(slabs, [](const IndexRecord& slab) { return std::array{slab.extent->cells}; }));
  }
  if (used) {
    used = use(columnOf(slabs, [](const IndexRecord& slab) {
      const auto& [min, max] = slab.extent->bounds;
      return std::array{min[0], min[1], min[2], max[0], max[1], max[2]};
    }));
  }
  return used;
}

/// Fails if the next array is not `expected`.
Result<void> compareArray(PayloadReader& from, const Features& features,
                          const MadeArray& expected) {
  const auto packed = takePacked(from, features);
  if (!packed) return packed.error();
  if (auto right = checkArray(*packed, expected.type, expected.components); !right) return right;
  if (packed->rows != expected.rows) {
    return invalid(
        fmt::format("it has {} rows where {} are expected", packed->rows, expected.rows));
  }
  std::vector<std::byte> said;
  std::vector<std::byte> found;
  const std::size_t rowBytes = packed->rowBytes();
  for (std::size_t i = 0; i < packed->blocks.size(); ++i) {
    const std::uint64_t first = i * kBlockRows;
    said.resize(std::min<std::uint64_t>(kBlockRows, packed->rows - first) * rowBytes);
    found.resize(said.size());
    if (auto unpacked = unpackBlock(*packed, i, said); !unpacked) return unpacked;
    expected.make(first, found);
    const auto [other, same] = std::ranges::mismatch(said, found);
    if (other == said.end()) continue;
    return invalid(fmt::format("its row {} is not what the file has",
                               first + static_cast<std::size_t>(other - said.begin()) / rowBytes));
  }
  return {};
}

/// The rows of such an array, which must be as many as there are records; `set` takes each of them.
template <class Number, std::size_t kComponents, class Set>
Result<void> takeColumn(PayloadReader& from, std::span<IndexRecord> records,
                        const Features& features, Set set) {
  const auto array = takeArrayOf(from, model::scalarTypeOf<Number>(), kComponents, features);
  if (!array) return array.error();
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

}  // namespace

Result<std::vector<ChunkHeader>> takeHeaders(PayloadReader& from, const Features& features,
                                             std::uint64_t offset) {
  const auto array =
      takeArrayOf(from, ScalarType::UInt8, t4d_layout::kDirectoryEntryBytes, features);
  if (!array) return array.error();
  std::vector<ChunkHeader> headers;
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

void putHeaders(PayloadWriter& into, const Rows<ChunkHeader>& chunks, int level) {
  putArray(into, columnOfHeaders(chunks), level);
}

void putSlabs(PayloadWriter& into, const Rows<IndexRecord>& slabs, int level) {
  (void)eachColumn(slabs, [&](const MadeArray& column) -> Result<void> {
    putArray(into, column, level);
    return {};
  });
}

Result<void> takeSlabs(PayloadReader& from, std::span<IndexRecord> all, const Features& features) {
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
  return taken;
}

PayloadWriter encodeIndex(const IndexFront& front, const Rows<ChunkHeader>& chunks,
                          const Rows<IndexRecord>& slabs, int level) {
  PayloadWriter payload;
  payload.putBytes(front.fileHeader.data(), front.fileHeader.size());
  payload.put(static_cast<std::uint32_t>(slabs.count));
  putArray(payload, {ScalarType::UInt8, 1, std::as_bytes(std::span(front.head))}, 0);
  putHeaders(payload, chunks, level);
  putSlabs(payload, slabs, level);
  return payload;
}

PayloadWriter encodeIndex(const Index& index, int level) {
  return encodeIndex(index, rowsOf(index.chunks), rowsOf(index.slabs), level);
}

Result<IndexFront> takeIndexFront(PayloadReader& from, std::uint32_t& slabs) {
  IndexFront front;
  const auto fileHeader = from.takeBytes(front.fileHeader.size());
  slabs = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("the index");
  std::copy(fileHeader.begin(), fileHeader.end(), front.fileHeader.begin());
  const auto packedHead = takePacked(from, {});
  if (!packedHead) return packedHead.error();
  if (packedHead->type != ScalarType::UInt8 || packedHead->components != 1 ||
      packedHead->codec != Codec::Raw) {
    return invalid("its copy of HEAD is not bytes as they are");
  }
  const auto head = unpack(*packedHead);
  if (!head) return head.error();
  front.head.assign(reinterpret_cast<const char*>(head->data()), head->size());
  return front;
}

Result<void> compareIndex(const PayloadView& payload, const Features& features,
                          const IndexFront& front, const Rows<ChunkHeader>& chunks,
                          const Rows<IndexRecord>& slabs) {
  PayloadReader from(payload);
  std::uint32_t count = 0;
  const auto said = takeIndexFront(from, count);
  if (!said) return said.error();
  if (said->fileHeader != front.fileHeader) {
    return invalid("its copy of the file header is different");
  }
  if (said->head != front.head) return invalid("its copy of HEAD is different");
  if (count != slabs.count) {
    return invalid(fmt::format("it says that there are {} slabs, of {}", count, slabs.count));
  }
  const auto compare = [&](const MadeArray& column) {
    return compareArray(from, features, column);
  };
  auto compared = compare(columnOfHeaders(chunks));
  if (compared) compared = eachColumn(slabs, compare);
  return compared ? checkEnd(from) : compared;
}

Result<Index> decodeIndex(const PayloadView& payload, const Features& features) {
  PayloadReader from(payload);
  std::uint32_t slabs = 0;
  auto front = takeIndexFront(from, slabs);
  if (!front) return front.error();
  Index index{std::move(*front), {}, {}};
  auto headers = takeHeaders(from, features, t4d_layout::kFileHeaderBytes);
  if (!headers) return headers.error();
  index.chunks = std::move(*headers);
  if (slabs > index.chunks.size()) {
    return invalid(
        fmt::format("it says that there are {} slabs among {} chunks", slabs, index.chunks.size()));
  }
  index.slabs.resize(slabs);
  const std::span all(index.slabs);
  auto taken = takeSlabs(from, all, features);
  if (taken) taken = checkEnd(from);
  if (taken) taken = placeSlabs(index.chunks, all);
  if (!taken) return taken.error();
  for (const IndexRecord& slab : all) {
    if (auto checked = checkTime(slab.time); !checked) {
      return invalid(fmt::format("the slab at byte {}: {}", slab.slab, checked.error().message));
    }
  }
  return index;
}

}  // namespace t4d::formats
