#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "conformance/corpus/slice_parts.h"

/// Damage to valid .t4d files that a reader must detect, or that is in parts which it must not
/// read.
namespace t4d::conformance {

/// The fields of file header and footer, and for each chunk the fields of its header, its payload
/// and its padding: together all bytes of a valid file. Empty parts are omitted.
std::vector<Part> partsOf(const std::string& bytes);

/// Lengths to truncate the file to that may each have a different effect: before, in and after
/// chunk headers, in payloads and in the footer.
std::vector<std::uint64_t> cutLengths(const std::string& bytes);

/// A bit of a file.
struct Bit {
  std::uint64_t offset = 0;  ///< of its byte in the file
  int bit = 0;               ///< from 0, the lowest, to 7
};
/// Chooses a bit of the part; every call returns the same one.
Bit bitOf(const Part& part);

/// At most `most` of the numbers below `count`, ascending and pseudo-random, determined by `seed`.
std::vector<std::size_t> someOf(std::size_t count, std::size_t most, std::uint64_t seed);

enum class Garbage : std::uint8_t { Ones, Noise };

std::string flipped(std::string bytes, Bit bit);
std::string overwritten(std::string bytes, const std::vector<Part>& parts, Garbage garbage);

struct Cut {
  std::uint64_t length = 0;
};
struct Overwrite {
  std::vector<Part> parts;
  Garbage garbage = Garbage::Ones;
};
/// The damage done to a file; none by default.
using Damage = std::variant<std::monostate, Cut, Bit, Overwrite>;

bool isNone(const Damage& damage);
std::string damaged(const std::string& bytes, const Damage& damage);

}  // namespace t4d::conformance
