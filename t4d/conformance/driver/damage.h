#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/model/error.h"

/// Damage to the bytes of valid .t4d files, which a reader must detect, or must not read.
namespace t4d::conformance {

/// A part of a file.
struct Part {
  std::string name;  ///< "the length of SLAB at byte 304"
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

/// The fields of file header and footer, and of each chunk the fields of its header, its payload
/// and its padding: all bytes of a valid file. Empty parts are left out.
std::vector<Part> partsOf(const std::string& bytes);

/// Lengths to which truncating the file may have an effect of its own: before, in and after the
/// headers of chunks, in payloads and in the footer.
std::vector<std::uint64_t> cutLengths(const std::string& bytes);

/// A bit of a file.
struct Bit {
  std::uint64_t offset = 0;  ///< of its byte in the file
  int bit = 0;               ///< from 0, the lowest, to 7
};
/// A bit of the part, always the same one.
Bit bitOf(const Part& part);

/// The parts of a file with index that a slice at a time reads, and those that it does not need.
struct SliceParts {
  std::vector<Part> read;      ///< file header, HEAD, DONE, INDX, footer, and what it is cut from
  std::vector<Part> unneeded;  ///< SLAB, CONN and LAYR chunks
};
/// Errors: the file has no index, or is not valid.
Result<SliceParts> partsForSlice(const std::string& bytes, double time);

/// The time in the middle of the first slab, if a slice there needs all slabs and parts and the
/// file has an index.
std::optional<double> timeThatNeedsAll(const std::string& bytes);

/// At most `most` of the numbers below `count`, ascending and pseudo-random: the same for the same
/// `seed`.
std::vector<std::size_t> someOf(std::size_t count, std::size_t most, std::uint64_t seed);

enum class Garbage : std::uint8_t { Ones, Noise };

std::string flipped(std::string bytes, Bit bit);
std::string overwritten(std::string bytes, const std::vector<Part>& parts, Garbage garbage);

}  // namespace t4d::conformance
