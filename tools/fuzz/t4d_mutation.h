#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Mutations of .t4d files that are wrong in one place only: after a chunk is mutated, checksums,
/// offsets and counts elsewhere can be updated, because readers would stop at them otherwise.
namespace t4d::fuzz {

struct LooseChunk {
  std::array<char, 4> type{};
  std::uint32_t flags = 0;
  std::string fields;
  std::vector<std::string> blocks;
  std::uint64_t offset = 0;  ///< in the file that it was read from
};

struct LooseFile {
  std::string header;  ///< 24 bytes
  std::vector<LooseChunk> chunks;
  std::string rest;  ///< everything after the last chunk: the footer, or garbage
};

/// Splits bytes into chunks by their lengths, as far as possible. Checksums are ignored.
LooseFile takeApart(const std::string& bytes);

/// The parts of a file that are updated when it is reassembled.
struct Repairs {
  bool parts = true;  ///< the offsets of CONN and LAYR in each SLAB
  bool index = true;  ///< INDX, the chunk count in DONE, and the footer
};

/// Reassembles a file, with valid checksums.
std::string putTogether(LooseFile file, const Repairs& repairs);

/// Corrects the summaries in DONE, if the slabs can be read.
std::string withTrueSums(const std::string& bytes);

}  // namespace t4d::fuzz
