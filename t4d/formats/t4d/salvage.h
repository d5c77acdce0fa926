#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/t4d/metadata.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// A part of a damaged file that cannot be used.
struct T4dLoss {
  std::uint64_t offset = 0;  ///< in the file
  std::string what;
  std::optional<model::TimeSpan> time;  ///< of a slab, where known
};

/// The whole slabs of a damaged or truncated .t4d file (SPEC.md, section "From the front"). A slab
/// is whole where its chunk, its connectivity and its layers are; what else the file has lost does
/// not matter to it. Memory is that of a slab or two for each body and of a record for each slab;
/// every number is held against the file's size before memory is asked for.
class T4dSalvage {
 public:
  /// Reads the file through. Fails where it cannot be opened, is not a .t4d file, or is one of a
  /// version or with features that this reader does not know; damage is no error.
  static Result<T4dSalvage> open(const std::filesystem::path& path,
                                 const model::Progress& progress = {});

  /// Whether a slab can be saved, going by the first `bytes` of the file.
  static bool finds(const std::filesystem::path& path, std::uint64_t bytes);

  T4dSalvage(T4dSalvage&&) noexcept;
  T4dSalvage& operator=(T4dSalvage&&) noexcept;
  ~T4dSalvage();

  /// What HEAD says, but for the bodies: these are the ones that have slabs, in order, as named in
  /// HEAD or, where HEAD is lost, "body 0", "body 1" and so on by their numbers in the slabs.
  const Metadata& metadata() const;
  bool metadataSaved() const;

  /// The slabs of metadata().bodies[index], in time order, each sound by itself; slabs between them
  /// may be missing. Lives as long as this. A body of a damaged file of which only caps are left
  /// has no solid and is counted as lost.
  const model::Source& body(std::size_t index) const;
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const;

  std::uint64_t slabsSaved() const;
  /// How many slabs the file had, where its index or end mark is whole.
  std::optional<std::uint64_t> slabsKnown() const;

  /// By offset; empty for a file that is valid (checkT4dFile).
  const std::vector<T4dLoss>& losses() const;

 private:
  class File;
  explicit T4dSalvage(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

}  // namespace t4d::formats
