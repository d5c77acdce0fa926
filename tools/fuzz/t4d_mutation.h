#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Mutations of .t4d files that are wrong in one place only: after a mutation of one chunk, the
/// checksums, offsets and counts of the rest can be updated, or readers would stop at them.
namespace t4d::fuzz {

struct LooseChunk {
  std::array<char, 4> type{};
  std::uint32_t flags = 0;
  std::string payload;
  std::uint64_t offset = 0;  ///< where it was read
};

struct LooseFile {
  std::string header;  ///< 24 bytes
  std::vector<LooseChunk> chunks;
  std::string rest;  ///< what follows the last chunk: the footer, or anything
};

/// Splits bytes into chunks by their lengths, as far as possible; ignores checksums.
LooseFile takeApart(const std::string& bytes);

/// What is updated when a file is put together.
struct Repairs {
  bool parts = true;  ///< offsets of CONN and LAYR in each SLAB, to where those have moved
  bool index = true;  ///< INDX, the count of chunks in DONE, and the footer
};

/// Puts a file together, with valid checksums.
std::string putTogether(LooseFile file, const Repairs& repairs);

/// Corrects the summaries in DONE, if the slabs can be read.
std::string withTrueSums(const std::string& bytes);

}  // namespace t4d::fuzz
