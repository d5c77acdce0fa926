#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunk_writer.h"

namespace t4d::formats {

/// Whether a chunk is one that this version does not know, not padding.
bool isUnknown(t4d_layout::ChunkType type);

/// Whether an editor that does not know chunks of this type may copy them (SPEC.md, rule E2).
bool isSafeToCopy(t4d_layout::ChunkType type);

/// The chunks of a file that this version does not know.
class OptionalChunks {
 public:
  using Take = std::function<Result<void>(const ChunkFile& file, const ChunkHeader& header)>;
  using Walk = std::function<Result<void>(const Take& take)>;

  OptionalChunks() = default;
  /// `file` must outlive this.
  explicit OptionalChunks(const ChunkFile& file) : file_(&file) {}
  /// The chunks that `walk` passes on, in order.
  explicit OptionalChunks(Walk walk) : walk_(std::move(walk)) {}

  /// Takes the chunk if it is one of those; call in file order.
  void add(const ChunkHeader& header) {
    if (isUnknown(header.type)) headers_.push_back(header);
  }
  /// Passes them on in order, up to the first error.
  Result<void> each(const Take& take) const;

 private:
  const ChunkFile* file_ = nullptr;
  std::vector<ChunkHeader> headers_;
  Walk walk_;
};

/// The chunks that an editor leaves out because it does not know them: how many of each type, and
/// their bytes.
class LostChunks {
 public:
  void add(const ChunkHeader& header);
  /// A line for each type.
  std::vector<std::string> lines() const;

 private:
  std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> types_;
};

/// Copies the chunks that may be copied, and adds the others to `lost`. Fails for a critical chunk,
/// and if a chunk is damaged.
Result<void> copyOptionalChunks(const OptionalChunks& chunks, ChunkWriter& into, LostChunks& lost);

}  // namespace t4d::formats
