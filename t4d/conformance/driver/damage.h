#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/model/error.h"

/// Damage to valid .t4d files that a reader must detect, or in parts that it must not read.
namespace t4d::conformance {

/// A part of a file.
struct Part {
  std::string name;  ///< "the length of SLAB at byte 304"
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

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
/// A bit of the part; every call returns the same one.
Bit bitOf(const Part& part);

/// The parts of an indexed file that a slice at some time reads, and those that it does not need.
struct SliceParts {
  std::vector<Part> read;      ///< DONE, INDX, footer, and the chunks of its slab
  std::vector<Part> unneeded;  ///< SLAB, CONN and LAYR chunks
};
/// Fails if the file has no index or is invalid.
Result<SliceParts> partsForSlice(const std::string& bytes, double time);

/// The time in the middle of the first slab, if the file has an index and a slice there needs all
/// slabs and parts.
std::optional<double> timeThatNeedsAll(const std::string& bytes);

/// At most `most` of the numbers below `count`, ascending and pseudo-random, determined by `seed`.
std::vector<std::size_t> someOf(std::size_t count, std::size_t most, std::uint64_t seed);

enum class Garbage : std::uint8_t { Ones, Noise };

std::string flipped(std::string bytes, Bit bit);
std::string overwritten(std::string bytes, const std::vector<Part>& parts, Garbage garbage);

}  // namespace t4d::conformance
