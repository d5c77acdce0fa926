#include "conformance/driver/damage.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <span>

#include <fmt/format.h>

#include "formats/t4d/chunk_list.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/layout.h"

namespace t4d::conformance {
namespace {

using namespace formats::t4d_layout;
using formats::ChunkHeader;
using formats::listChunks;

std::span<const std::byte> view(const std::string& bytes, std::uint64_t offset,
                                std::uint64_t size) {
  return std::as_bytes(std::span(bytes)).subspan(offset, size);
}

bool hasIndex(const std::string& bytes) {
  ByteReader header(view(bytes, 12, 4));
  return (header.take<std::uint32_t>() & kFlagIndexed) != 0;
}

/// A pseudo-random number derived from another number (splitmix64).
std::uint64_t mixed(std::uint64_t number) {
  number += 0x9E3779B97F4A7C15;
  number = (number ^ (number >> 30)) * 0xBF58476D1CE4E5B9;
  number = (number ^ (number >> 27)) * 0x94D049BB133111EB;
  return number ^ (number >> 31);
}

}  // namespace

std::vector<Part> partsOf(const std::string& bytes) {
  std::vector<Part> parts = {{"the signature", 0, 8},
                             {"the version", 8, 4},
                             {"the flags of the file", 12, 4},
                             {"the reserved bytes of the file header", 16, 4},
                             {"the checksum of the file header", 20, 4}};
  const std::vector<ChunkHeader> chunks = listChunks(bytes);
  for (const ChunkHeader& chunk : chunks) {
    const auto add = [&](const char* what, std::uint64_t offset, std::uint64_t size) {
      parts.push_back(
          {fmt::format("the {} of {} at byte {}", what, chunk.name(), chunk.offset), offset, size});
    };
    add("type", chunk.offset, 4);
    add("flags", chunk.offset + 4, 4);
    add("length", chunk.offset + 8, 8);
    add("front and the number of blocks", chunk.offset + 16, 8);
    add("front checksum", chunk.offset + 24, 4);
    add("header checksum", chunk.offset + 28, 4);
    add("front", chunk.payload(), chunk.frontBytes);
    add("blocks", chunk.payload() + chunk.frontBytes, chunk.payloadBytes - chunk.frontBytes);
    add("padding", chunk.payload() + chunk.payloadBytes,
        padded(chunk.payloadBytes) - chunk.payloadBytes);
  }
  if (hasIndex(bytes)) {
    const std::uint64_t footer = bytes.size() - kFooterBytes;
    parts.insert(parts.end(), {{"the offset of INDX in the footer", footer, 8},
                               {"the offset of DONE in the footer", footer + 8, 8},
                               {"the file length in the footer", footer + 16, 8},
                               {"the checksum of INDX in the footer", footer + 24, 4},
                               {"the checksum of the footer", footer + 28, 4},
                               {"the end signature", footer + 32, 8}});
  }
  std::erase_if(parts, [](const Part& part) { return part.size == 0; });
  return parts;
}

std::vector<std::uint64_t> cutLengths(const std::string& bytes) {
  std::set<std::uint64_t> lengths = {0, 8, kFileHeaderBytes - 1, bytes.size() - 1};
  if (hasIndex(bytes)) lengths.insert({bytes.size() - kFooterBytes, bytes.size() - 8});
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    lengths.insert({chunk.offset, chunk.offset + 4, chunk.payload(),
                    chunk.payload() + chunk.payloadBytes / 2, chunk.end() - 1});
  }
  return {lengths.begin(), lengths.end()};
}

std::vector<std::size_t> someOf(std::size_t count, std::size_t most, std::uint64_t seed) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  if (count <= most) return numbers;
  std::sort(numbers.begin(), numbers.end(), [&](std::size_t a, std::size_t b) {
    return mixed(mixed(seed) + a) < mixed(mixed(seed) + b);
  });
  numbers.resize(most);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

Bit bitOf(const Part& part) {
  const std::uint64_t chance = mixed(part.offset * 64 + part.size);
  return {part.offset + chance / 8 % part.size, static_cast<int>(chance % 8)};
}

std::string flipped(std::string bytes, Bit bit) {
  bytes[bit.offset] = static_cast<char>(bytes[bit.offset] ^ (1 << bit.bit));
  return bytes;
}

std::string overwritten(std::string bytes, const std::vector<Part>& parts, Garbage garbage) {
  for (const Part& part : parts) {
    for (std::uint64_t at = part.offset; at < part.offset + part.size; ++at) {
      bytes[at] = static_cast<char>(garbage == Garbage::Ones ? 0xFF : mixed(at));
    }
  }
  return bytes;
}

bool isNone(const Damage& damage) { return std::holds_alternative<std::monostate>(damage); }

std::string damaged(const std::string& bytes, const Damage& damage) {
  if (const auto* cut = std::get_if<Cut>(&damage)) return bytes.substr(0, cut->length);
  if (const auto* bit = std::get_if<Bit>(&damage)) return flipped(bytes, *bit);
  if (const auto* over = std::get_if<Overwrite>(&damage)) {
    return overwritten(bytes, over->parts, over->garbage);
  }
  return bytes;
}

}  // namespace t4d::conformance
