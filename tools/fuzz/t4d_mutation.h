#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// .t4d files that are wrong in one place only: whatever a mutation does to one chunk, the
/// checksums, offsets and counts of the rest can be made to follow, or a reader would never get
/// past them.
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

/// Takes bytes apart as far as there are chunks by their lengths; checksums do not matter.
LooseFile takeApart(const std::string& bytes);

/// What is made to follow the rest when a file is put together.
struct Repairs {
  bool parts = true;  ///< offsets of CONN and LAYR in each SLAB, to where those have moved
  bool index = true;  ///< INDX, the count of chunks in DONE, and the footer
};

/// With right checksums.
std::string putTogether(LooseFile file, const Repairs& repairs);

/// Makes every checksum of a file right and nothing else.
void repairChecksums(std::string& bytes);

/// Makes DONE tell the truth of the slabs, if they can be read.
std::string withTrueSums(const std::string& bytes);

}  // namespace t4d::fuzz
