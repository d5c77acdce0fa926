#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::formats {

class OptionalChunks;

/// A part of a damaged file that cannot be used.
struct T4dLoss {
  std::uint64_t offset = 0;  ///< in the file
  std::string what;
  std::optional<model::TimeSpan> time;  ///< of a slab, if known
};

/// The intact slabs of a damaged or truncated .t4d file (SPEC.md, section "From the front"). A slab
/// is intact if its chunk, its connectivity and its layers are, whatever else the file has lost.
/// Memory use is one or two slabs per body and one record per slab; every number is checked against
/// the file's size before memory is allocated.
class T4dSalvage {
 public:
  /// Reads the file through. Fails if it cannot be opened, is not a .t4d file, or has a version or
  /// features that this reader does not support. Damage is not an error.
  static Result<T4dSalvage> open(const std::filesystem::path& path,
                                 const model::Progress& progress = {});

  /// Whether the first `bytes` bytes of the file suggest that a slab can be saved.
  static bool finds(const std::filesystem::path& path, std::uint64_t bytes);

  T4dSalvage(T4dSalvage&&) noexcept;
  T4dSalvage& operator=(T4dSalvage&&) noexcept;
  ~T4dSalvage();

  /// The metadata in HEAD, except for the bodies. These are the ones that have slabs, in order,
  /// named as in HEAD or, if HEAD is lost, "body 0", "body 1" and so on by their numbers in the
  /// slabs.
  const Metadata& metadata() const;
  bool metadataSaved() const;

  /// The slabs of metadata().bodies[index], in time order, each valid on its own; slabs between
  /// them may be missing. Valid as long as this object. A body of a damaged file of which only caps
  /// are left has no solid and is counted as lost.
  const model::Source& body(std::size_t index) const;
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const;

  /// The intact chunks that this version does not know, for T4dWriter::keep; valid as long as this
  /// object.
  const OptionalChunks& optionalChunks() const;

  std::uint64_t slabsSaved() const;
  /// The number of slabs that the file had, if its index or end mark is intact.
  std::optional<std::uint64_t> slabsKnown() const;

  /// Ordered by offset; empty for a valid file (checkT4dFile).
  const std::vector<T4dLoss>& losses() const;

 private:
  class File;
  explicit T4dSalvage(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

}  // namespace t4d::formats
