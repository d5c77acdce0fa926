#include "tools/fuzz/t4d_mutation.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <random>

#include "t4d/formats/t4d/array_codec.h"
#include "t4d/formats/t4d/chunk_list.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/formats/t4d/layout.h"
#include "t4d/formats/t4d/reader.h"
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

std::string indexOf(const std::vector<LooseChunk>& chunks, const std::vector<std::uint64_t>& at) {
  std::string payload(8, '\0');
  std::uint64_t slabs = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    if (chunks[i].type != kSlab) continue;
    ++slabs;
    const std::uint64_t place[] = {at[i], kChunkHeaderBytes + padded(chunks[i].payload.size())};
    append(payload, place, sizeof place);
    std::string fields = chunks[i].payload.substr(0, 44);
    fields.resize(48);
    payload += fields;
  }
  setNumber(payload, 0, slabs);
  return payload;
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

/// Offsets in a payload where array records may be.
std::vector<std::size_t> arraysIn(const std::string& payload) {
  std::vector<std::size_t> found;
  for (std::size_t at = 0; at + kArrayHeaderBytes <= payload.size(); at += kAlignment) {
    const auto type = static_cast<model::ScalarType>(payload[at]);
    if (model::scalarSize(type) != 0 && payload[at + 1] != 0 &&
        numberAt<std::uint32_t>(payload, at + 4) == 0 &&
        numberAt<std::uint64_t>(payload, at + 16) <= payload.size() - at - kArrayHeaderBytes) {
      found.push_back(at);
    }
  }
  return found;
}

/// Replaces an array by one of a different type, length or codec.
void remakeArray(std::string& payload, Choices& choose) {
  const auto arrays = arraysIn(payload);
  if (arrays.empty()) return;
  const std::size_t at = arrays[choose.below(arrays.size())];
  const std::size_t stored = numberAt<std::uint64_t>(payload, at + 16);
  const std::size_t end =
      std::min<std::size_t>(payload.size(), at + kArrayHeaderBytes + padded(stored));
  formats::ArrayView array;
  array.type = static_cast<model::ScalarType>(payload[at]);
  array.components = static_cast<std::uint8_t>(payload[at + 1]);
  formats::t4d_layout::ByteReader from(std::as_bytes(std::span(payload)).subspan(at));
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
  ByteWriter record;
  formats::putArray(record, array, choose.oneIn(2) ? 1 : 0);
  payload.replace(at, end - at, reinterpret_cast<const char*>(record.data()), record.size());
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
      break;
    }
    case 1:
      file.chunks.erase(file.chunks.begin() + static_cast<std::ptrdiff_t>(one));
      break;
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
      remakeArray(chunk.payload, choose);
      break;
    case 7:
    case 8:
      replaceField(chunk.payload, choose);
      break;
    default:
      mutateBytes(chunk.payload, chunk.payload.size() + room);
  }
}

}  // namespace

LooseFile takeApart(const std::string& bytes) {
  LooseFile file;
  file.header = bytes.substr(0, kFileHeaderBytes);
  file.header.resize(kFileHeaderBytes);
  std::size_t end = std::min(kFileHeaderBytes, bytes.size());
  for (const formats::ChunkHeader& chunk : formats::listChunks(bytes)) {
    file.chunks.push_back(
        {chunk.type, chunk.flags, bytes.substr(chunk.payload(), chunk.payloadBytes), chunk.offset});
    end = chunk.end();
  }
  file.rest = bytes.substr(end);
  return file;
}

std::string putTogether(LooseFile file, const Repairs& repairs) {
  // The length of INDX does not depend on its contents, so offsets are known before it is made.
  std::size_t slabs = 0;
  for (const LooseChunk& chunk : file.chunks) slabs += chunk.type == kSlab ? 1 : 0;
  std::vector<std::uint64_t> offsets;
  std::map<std::uint64_t, std::uint64_t> moved;
  std::uint64_t at = kFileHeaderBytes;
  for (LooseChunk& chunk : file.chunks) {
    if (repairs.index && chunk.type == kIndex) {
      chunk.payload.resize(8 + slabs * kIndexRecordBytes);
    }
    offsets.push_back(at);
    moved.emplace(chunk.offset, at);
    at += kChunkHeaderBytes + padded(chunk.payload.size());
  }
  if (repairs.parts) {
    for (LooseChunk& chunk : file.chunks) {
      if (chunk.type != kSlab) continue;
      for (std::size_t part = 0; part < kSlabParts; ++part) {
        const std::size_t field = kSlabConnectivity + 8 * part;
        const auto found = moved.find(numberAt<std::uint64_t>(chunk.payload, field));
        if (found != moved.end()) setNumber(chunk.payload, field, found->second);
      }
    }
  }
  std::uint64_t doneAt = 0;
  std::uint64_t indexAt = 0;
  for (std::size_t i = 0; i < file.chunks.size(); ++i) {
    LooseChunk& chunk = file.chunks[i];
    if (chunk.type == kDone) {
      doneAt = offsets[i];
      if (repairs.index) setNumber(chunk.payload, 0, std::uint64_t{i});
    }
    if (chunk.type == kIndex) {
      indexAt = offsets[i];
      if (repairs.index) chunk.payload = indexOf(file.chunks, offsets);
    }
  }
  if (repairs.index && endsWithSignature(file.rest)) {
    const std::size_t footer = file.rest.size() - kFooterBytes;
    setNumber(file.rest, footer, indexAt);
    setNumber(file.rest, footer + 8, doneAt);
    setNumber(file.rest, footer + 16, std::uint64_t{at + file.rest.size()});
  }

  std::string bytes = file.header;
  for (const LooseChunk& chunk : file.chunks) {
    append(bytes, chunk.type.data(), chunk.type.size());
    append(bytes, &chunk.flags, sizeof chunk.flags);
    const std::uint64_t length = chunk.payload.size();
    append(bytes, &length, sizeof length);
    bytes.append(8, '\0');
    bytes += chunk.payload;
    bytes.resize(padded(bytes.size()));
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
  const ByteWriter payload = encodeDone(done);
  LooseFile loose = takeApart(bytes);
  for (LooseChunk& chunk : loose.chunks) {
    if (chunk.type != kDone) continue;
    chunk.payload.assign(reinterpret_cast<const char*>(payload.data()), payload.size());
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
