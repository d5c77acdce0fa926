#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/error.h"

/// The parts of an indexed file that a slice at a time reads (SPEC.md, the appendix).
namespace t4d::conformance {

/// A part of a file.
struct Part {
  std::string name;  ///< "the length of SLAB at byte 304"
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

/// The parts of an indexed file that a slice at some time reads, and those that it does not need.
struct SliceParts {
  std::vector<Part> read;      ///< DONE, INDX, footer, and the chunks of its slab
  std::vector<Part> unneeded;  ///< SLAB, CONN and LAYR chunks
};
/// Fails if the file has no index or is invalid.
Result<SliceParts> partsForSlice(const std::string& bytes, double time);

/// A time at which a slice reads the chunk that holds the byte at `offset`, or the footer; nothing
/// if no slice does, or the file has no index that can be read.
std::optional<double> timeThatReads(const std::string& bytes, std::uint64_t offset);

}  // namespace t4d::conformance
