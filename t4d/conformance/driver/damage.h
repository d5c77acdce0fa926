#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/model/error.h"

/// Damage done to the bytes of whole, valid .t4d files, which a reader must notice, or must not
/// see.
namespace t4d::conformance {

/// A part of a file.
struct Part {
  std::string name;  ///< "the length of SLAB at byte 304"
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

/// The fields of file header and footer, and of each chunk the fields of its header, its payload
/// and its padding: together all of a valid file's bytes. Those without bytes are left out.
std::vector<Part> partsOf(const std::string& bytes);

/// Lengths less than the file's that lie before, in and behind the headers of chunks, in payloads
/// and in the footer: where cutting a file off may do something of its own.
std::vector<std::uint64_t> cutLengths(const std::string& bytes);

/// One bit of a part, always the same.
struct Bit {
  std::uint64_t offset = 0;  ///< of its byte in the file
  int bit = 0;               ///< from 0, the lowest, to 7
};
Bit bitOf(const Part& part);

/// What a slice at a time reads of a file with index, and what it does not need.
struct SliceParts {
  std::vector<Part> read;      ///< file header, HEAD, DONE, INDX, footer, and what it is made of
  std::vector<Part> unneeded;  ///< SLAB, CONN and LAYR chunks, in whole
};
/// Errors: the file has no index, or is not valid.
Result<SliceParts> partsForSlice(const std::string& bytes, double time);

/// A time at which a slice needs all slabs and parts; none where the file has no index, or there is
/// no such time in the middle of its first slab.
std::optional<double> timeThatNeedsAll(const std::string& bytes);

/// At most `most` of the numbers below `count`, ascending, as if drawn by lot; by `seed` always the
/// same.
std::vector<std::size_t> someOf(std::size_t count, std::size_t most, std::uint64_t seed);

enum class Garbage : std::uint8_t { Ones, Noise };

std::string flipped(std::string bytes, Bit bit);
std::string overwritten(std::string bytes, const std::vector<Part>& parts, Garbage garbage);

}  // namespace t4d::conformance
