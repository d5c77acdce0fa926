#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <unordered_set>
#include <vector>

#include "formats/t4d/file_copy.h"
#include "formats/t4d/part_window.h"

namespace t4d::formats {

/// Copies the chunks of files that continue each other into one file, as a single writer would have
/// stored them: the layer at a seam once, and a connectivity that an earlier part has, too, only
/// there. Distances that change by this are corrected; all other bytes are copied as they are.
class PartCopier {
 public:
  /// `anySize`: whether connectivities of more than 4 MiB are looked for, too.
  PartCopier(ChunkWriter& into, std::size_t bodies, bool anySize)
      : into_(into), window_(bodies), uppers_(bodies), anySize_(anySize), given_(bodies) {}

  /// The next file. `lowers` has, for each body that continues, the offset of its first lower
  /// layer there, which is equal to the last upper layer of that body; 0 for others.
  void begin(const std::filesystem::path& path, const ChunkFile& file,
             const std::vector<std::uint64_t>& lowers);

  Result<void> put(const ChunkFile::Chunk& chunk);
  Result<void> putSlab(const ChunkFile::Chunk& chunk, const IndexRecord& record);

 private:
  struct Stored {
    std::filesystem::path file;
    ChunkHeader header;  // there
    std::vector<std::byte> front;
    std::size_t counted = 0;   // bytes, as T4dWriter counts them
    std::uint64_t offset = 0;  // where it was copied to
  };

  /// Where the chunk of this part is that begins at `offset`; copies it again if it is too far back
  /// to be named.
  Result<std::uint64_t> nameable(std::uint64_t offset, t4d_layout::ChunkType type);
  Result<std::uint64_t> copy(const ChunkHeader& header, std::span<const std::byte> payload);
  Result<bool> takeStored(const ChunkFile::Chunk& chunk);
  Result<bool> isSame(const Stored& one, const ChunkHeader& other) const;
  void forgetPlaces();
  void store(const ChunkFile::Chunk& chunk, std::uint64_t offset);

  ChunkWriter& into_;
  PartWindow window_;
  std::vector<std::uint64_t> uppers_;  // of the bodies, where their last upper layers are
  bool anySize_;
  std::filesystem::path path_;
  const ChunkFile* file_ = nullptr;
  PartWindow given_;                               // chunks of this part that it may name
  std::vector<std::uint64_t> uppersThere_;         // what uppers_ are in this part
  std::map<std::uint64_t, std::uint64_t> placed_;  // of this part: where those are now
  std::size_t forgetAt_ = 0;
  std::set<std::uint64_t> atSeam_;
  std::unordered_set<std::size_t> seen_;  // hashes of the connectivities of this part
  std::deque<Stored> stored_;
  std::size_t storedBytes_ = 0;
};

}  // namespace t4d::formats
