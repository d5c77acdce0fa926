#include "tools/fuzz/t4d_mutation.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <random>
#include <span>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/chunk_list.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/layout.h"
#include "t4d/file.h"
#include "tools/fuzz/fuzz.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t maxSize);

namespace t4d::fuzz {
namespace {

using namespace formats::t4d_layout;

template <class T>
T numberAt(const std::string& bytes, std::size_t offset) {
  T value{};
  if (offset <= bytes.size() && sizeof value <= bytes.size() - offset) {
    std::memcpy(&value, bytes.data() + offset, sizeof value);
  }
  return value;
}

template <class T>
void setNumber(std::string& bytes, std::size_t offset, T value) {
  if (offset <= bytes.size() && sizeof value <= bytes.size() - offset) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
  }
}

void append(std::string& bytes, const void* data, std::size_t size) {
  bytes.append(static_cast<const char*>(data), size);
}

bool endsWithSignature(const std::string& bytes) {
  return bytes.size() >= kFooterBytes &&
         std::memcmp(bytes.data() + bytes.size() - 8, kEndSignature.data(), 8) == 0;
}

// Offsets of fields in payloads (SPEC.md).
constexpr std::size_t kSlabConnectivity = 16;
constexpr std::size_t kSlabParts = 3;
constexpr std::size_t kSlabBody = 40;
constexpr std::size_t kPoseLayer = 8;

std::vector<std::byte> bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

PayloadWriter payloadOf(const LooseChunk& chunk) {
  PayloadWriter payload;
  payload.putBytes(chunk.fields.data(), chunk.fields.size());
  for (const std::string& block : chunk.blocks)
    payload.putBlock(formats::StoredBlock(bytesOf(block)));
  return payload;
}

void setPayload(LooseChunk& chunk, const PayloadWriter& payload) {
  const auto text = [](std::span<const std::byte> bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  chunk.fields = text(payload.bytes());
  chunk.blocks.clear();
  for (const auto& block : payload.blocks()) chunk.blocks.push_back(text(block.bytes()));
}

/// The contents of INDX for `chunks`, of which it is one, where they can be told without reading
/// them. Its data about the contents of slabs is kept.
formats::Index indexOf(const std::string& fileHeader, const std::vector<LooseChunk>& chunks,
                       const formats::Index& before) {
  formats::Index index;
  std::memcpy(index.fileHeader.data(), fileHeader.data(), index.fileHeader.size());
  std::uint64_t offset = kFileHeaderBytes;
  for (const LooseChunk& chunk : chunks) {
    if (chunk.type == kIndex) break;
    if (chunk.type == kHead) index.head = chunk.fields;
    index.chunks.push_back(
        formats::frontOf(chunk.type, payloadOf(chunk), offset, chunk.flags).header);
    offset = index.chunks.back().end();
    if (chunk.type != kSlab) continue;
    formats::IndexRecord slab;
    slab.time = {numberAt<double>(chunk.fields, 0), numberAt<double>(chunk.fields, 8)};
    slab.parts.connectivity = numberAt<std::uint64_t>(chunk.fields, kSlabConnectivity);
    slab.parts.lower = numberAt<std::uint64_t>(chunk.fields, kSlabConnectivity + 8);
    slab.parts.upper = numberAt<std::uint64_t>(chunk.fields, kSlabConnectivity + 16);
    slab.parts.body = numberAt<std::uint32_t>(chunk.fields, kSlabBody);
    const std::size_t number = index.slabs.size();
    slab.extent = number < before.slabs.size() ? before.slabs[number].extent
                                               : std::optional(formats::SlabExtent());
    index.slabs.push_back(slab);
  }
  return index;
}

/// The random choices of one mutation.
class Choices {
 public:
  explicit Choices(unsigned seed) : random_(seed) {}
  std::size_t below(std::size_t count) { return random_() % count; }
  bool oneIn(std::size_t count) { return below(count) == 0; }

 private:
  std::minstd_rand random_;
};

void mutateBytes(std::string& bytes, std::size_t room) {
  std::vector<std::uint8_t> buffer(bytes.begin(), bytes.end());
  const std::size_t size = buffer.size();
  buffer.resize(std::max<std::size_t>({room, size, 1}));
  buffer.resize(LLVMFuzzerMutate(buffer.data(), size, buffer.size()));
  bytes.assign(buffer.begin(), buffer.end());
}

/// A place in the fields where the record of an array may be, and the first of its blocks.
struct ArrayPlace {
  std::size_t at = 0;
  std::size_t block = 0;
  std::size_t blocks = 0;
};

std::vector<ArrayPlace> arraysIn(const LooseChunk& chunk) {
  std::vector<ArrayPlace> found;
  std::size_t block = 0;
  for (std::size_t at = 0; at + kArrayHeaderBytes <= chunk.fields.size(); at += kAlignment) {
    const auto type = static_cast<model::ScalarType>(chunk.fields[at]);
    const auto rows = numberAt<std::uint64_t>(chunk.fields, at + 8);
    const std::uint64_t blocks = rows / kBlockRows + (rows % kBlockRows != 0 ? 1 : 0);
    if (model::scalarSize(type) == 0 || chunk.fields[at + 1] == 0 ||
        numberAt<std::uint32_t>(chunk.fields, at + 4) != 0 ||
        blocks > chunk.blocks.size() - block) {
      continue;
    }
    found.push_back({at, block, blocks});
    block += blocks;
  }
  return found;
}

/// Replaces an array by one of a different type, length or codec.
void remakeArray(LooseChunk& chunk, Choices& choose) {
  const auto arrays = arraysIn(chunk);
  if (arrays.empty()) return;
  const auto [at, block, blocks] = arrays[choose.below(arrays.size())];
  formats::ArrayView array;
  array.type = static_cast<model::ScalarType>(chunk.fields[at]);
  array.components = static_cast<std::uint8_t>(chunk.fields[at + 1]);
  const PayloadWriter payload = payloadOf(chunk);
  PayloadView view = payload.view();
  const auto begin = view.blocks.begin() + static_cast<std::ptrdiff_t>(block);
  view = {view.fields.subspan(at, kArrayHeaderBytes),
          {begin, begin + static_cast<std::ptrdiff_t>(blocks)}};
  PayloadReader from(view);
  auto taken = formats::takeArray(from);
  std::vector<std::byte> content = taken ? std::move(taken->bytes) : std::vector<std::byte>();
  if (choose.oneIn(4)) {
    array.type = static_cast<model::ScalarType>(1 + choose.below(10));
  }
  constexpr std::size_t kMostRows = 3000;
  const std::size_t had = content.size() / array.rowBytes();
  const std::size_t rows[] = {had, had + 1, had - (had > 0 ? 1 : 0), choose.below(20),
                              choose.below(kMostRows)};
  content.resize(rows[choose.below(std::size(rows))] * array.rowBytes());
  array.bytes = content;
  LooseChunk made;
  PayloadWriter record;
  formats::putArray(record, array, choose.oneIn(2) ? 1 : 0);
  setPayload(made, record);
  chunk.fields.replace(at, kArrayHeaderBytes, made.fields);
  const auto first = chunk.blocks.begin() + static_cast<std::ptrdiff_t>(block);
  chunk.blocks.erase(first, first + static_cast<std::ptrdiff_t>(blocks));
  chunk.blocks.insert(chunk.blocks.begin() + static_cast<std::ptrdiff_t>(block),
                      made.blocks.begin(), made.blocks.end());
}

/// Copies one field of four or eight bytes over another.
void replaceField(std::string& payload, Choices& choose) {
  if (payload.size() < 8) return;
  const std::size_t from = choose.below(payload.size() / 4) * 4;
  const std::size_t into = choose.below(payload.size() / 4) * 4;
  if (choose.oneIn(2)) {
    setNumber(payload, into, numberAt<std::uint32_t>(payload, from));
  } else {
    setNumber(payload, into & ~std::size_t{7}, numberAt<double>(payload, from & ~std::size_t{7}));
  }
}

void mutateChunks(LooseFile& file, std::size_t room, Choices& choose) {
  if (file.chunks.empty()) return;
  const std::size_t one = choose.below(file.chunks.size());
  LooseChunk& chunk = file.chunks[one];
  switch (choose.below(12)) {
    case 0: {
      // A vector cannot insert one of its own elements by move.
      LooseChunk copy = chunk;
      file.chunks.insert(
          file.chunks.begin() + static_cast<std::ptrdiff_t>(choose.below(file.chunks.size() + 1)),
          std::move(copy));
      return;
    }
    case 1:
      file.chunks.erase(file.chunks.begin() + static_cast<std::ptrdiff_t>(one));
      return;
    case 2:
      std::swap(chunk, file.chunks[choose.below(file.chunks.size())]);
      break;
    case 3:
      chunk.flags ^= 1U << choose.below(2);
      chunk.type[choose.below(4)] = "ABCDHILNSY4x"[choose.below(12)];
      break;
    case 4:
    case 5:
    case 6:
      remakeArray(chunk, choose);
      break;
    case 7:
    case 8:
      replaceField(chunk.fields, choose);
      break;
    default:
      if (!chunk.blocks.empty() && choose.oneIn(2)) {
        std::string& block = chunk.blocks[choose.below(chunk.blocks.size())];
        mutateBytes(block, block.size() + room);
      } else {
        mutateBytes(chunk.fields, chunk.fields.size() + room);
      }
  }
  // Blocks begin at a multiple of 8; mostly, so that something else is wrong.
  if (!chunk.blocks.empty() && !choose.oneIn(8)) {
    chunk.fields.resize(padded(chunk.fields.size()));
  }
}

}  // namespace

LooseFile takeApart(const std::string& bytes) {
  LooseFile file;
  file.header = bytes.substr(0, kFileHeaderBytes);
  file.header.resize(kFileHeaderBytes);
  std::size_t end = std::min(kFileHeaderBytes, bytes.size());
  for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) {
    LooseChunk loose{chunk.type, chunk.flags, {}, {}, chunk.offset};
    const auto payload =
        std::as_bytes(std::span(bytes)).subspan(chunk.payload(), chunk.payloadBytes);
    const std::uint64_t table = chunk.blocks * std::uint64_t{kBlockEntryBytes};
    const bool sound = chunk.frontBytes <= chunk.payloadBytes && table <= chunk.frontBytes;
    loose.fields = sound ? bytes.substr(chunk.fields(), chunk.frontBytes - table)
                         : bytes.substr(chunk.payload(), chunk.payloadBytes);
    ByteReader sizes(payload.first(sound ? table : 0));
    ByteReader blocks(payload.subspan(sound ? chunk.frontBytes : payload.size()));
    while (sizes.left() >= kBlockEntryBytes) {
      const auto size = sizes.take<std::uint32_t>();
      sizes.take<std::uint32_t>();
      const auto block = blocks.takeBytes(size);
      if (blocks.overrun()) break;
      loose.blocks.emplace_back(reinterpret_cast<const char*>(block.data()), block.size());
      blocks.skipPadding();
    }
    file.chunks.push_back(std::move(loose));
    end = chunk.end();
  }
  file.rest = bytes.substr(end);
  return file;
}

std::string putTogether(LooseFile file, const Repairs& repairs) {
  std::map<std::uint64_t, std::uint64_t> moved;
  std::vector<std::uint64_t> offsets;
  std::uint64_t at = kFileHeaderBytes;
  for (const LooseChunk& chunk : file.chunks) {
    // INDX may become longer or shorter: it is the last.
    offsets.push_back(at);
    moved.emplace(chunk.offset, at);
    at = formats::frontOf(chunk.type, payloadOf(chunk), at).header.end();
  }
  if (repairs.parts) {
    for (std::size_t i = 0; i < file.chunks.size(); ++i) {
      LooseChunk& chunk = file.chunks[i];
      const bool isPose = chunk.type == kPose;
      const std::size_t first = isPose ? kPoseLayer : kSlabConnectivity;
      const std::size_t parts = isPose ? 1 : chunk.type == kSlab ? kSlabParts : 0;
      for (std::size_t part = 0; part < parts; ++part) {
        const std::size_t field = first + 8 * part;
        const auto distance = numberAt<std::uint64_t>(chunk.fields, field);
        const auto found = moved.find(chunk.offset - distance);
        if (distance == 0 || found == moved.end()) continue;
        setNumber(chunk.fields, field, offsets[i] - found->second);
      }
    }
  }
  std::uint64_t doneAt = 0;
  std::uint64_t indexAt = 0;
  for (std::size_t i = 0; i < file.chunks.size(); ++i) {
    LooseChunk& chunk = file.chunks[i];
    if (chunk.type == kDone) {
      doneAt = offsets[i];
      if (repairs.index) setNumber(chunk.fields, 0, std::uint64_t{i});
    }
    if (chunk.type == kIndex) {
      indexAt = offsets[i];
      if (!repairs.index) continue;
      const PayloadWriter payload = payloadOf(chunk);
      auto before = formats::decodeIndex(payload.view());
      if (before) setPayload(chunk, encodeIndex(indexOf(file.header, file.chunks, *before), 0));
    }
  }
  std::string bytes = file.header;
  for (const LooseChunk& chunk : file.chunks) {
    const PayloadWriter payload = payloadOf(chunk);
    const auto [header, front] = formats::frontOf(chunk.type, payload, 0, chunk.flags);
    const formats::ChunkHeaderBytes encoded = encodeChunkHeader(header);
    append(bytes, encoded.data(), encoded.size());
    append(bytes, front.data(), front.size());
    for (const std::string& block : chunk.blocks) {
      bytes.resize(padded(bytes.size()));
      bytes += block;
    }
    bytes.resize(padded(bytes.size()));
  }
  if (repairs.index && endsWithSignature(file.rest)) {
    const std::size_t footer = file.rest.size() - kFooterBytes;
    setNumber(file.rest, footer, indexAt);
    setNumber(file.rest, footer + 8, doneAt);
    setNumber(file.rest, footer + 16, std::uint64_t{bytes.size() + file.rest.size()});
  }
  bytes += file.rest;
  formats::repairChecksums(bytes);
  return bytes;
}

std::string withTrueSums(const std::string& bytes) {
  static MemoryFile file;
  file.set({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  auto reader = formats::T4dReader::open(file.path(), formats::T4dOpen::FromFront);
  if (!reader) return bytes;
  formats::Done done;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    formats::BodySummary sum;
    const model::Source& body = reader->body(i);
    for (std::size_t k = 0; k < body.slabCount(); ++k) {
      const auto slab = body.slab(k);
      if (!slab) return bytes;
      addSlab(sum, **slab);
    }
    done.bodies.push_back(sum);
  }
  LooseFile loose = takeApart(bytes);
  for (LooseChunk& chunk : loose.chunks) {
    if (chunk.type == kDone) setPayload(chunk, encodeDone(done));
  }
  return putTogether(std::move(loose), {});
}

}  // namespace t4d::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed) {
  using namespace t4d::fuzz;
  Choices choose(seed);
  std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t way = choose.below(8);
  if (way < 2) {
    mutateBytes(bytes, maxSize);
    if (way == 1) t4d::formats::repairChecksums(bytes);
  } else {
    LooseFile file = takeApart(bytes);
    if (choose.oneIn(16)) mutateBytes(file.header, file.header.size());
    if (choose.oneIn(16)) mutateBytes(file.rest, file.rest.size());
    file.header.resize(t4d::formats::t4d_layout::kFileHeaderBytes);
    const std::size_t room = maxSize - std::min(maxSize, size);
    do {
      mutateChunks(file, room, choose);
    } while (choose.oneIn(3));
    bytes = putTogether(std::move(file), {!choose.oneIn(8), !choose.oneIn(8)});
    if (choose.oneIn(2)) bytes = withTrueSums(bytes);
  }
  const std::size_t kept = std::min(bytes.size(), maxSize);
  std::memcpy(data, bytes.data(), kept);
  return kept;
}
