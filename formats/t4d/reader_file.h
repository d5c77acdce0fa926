#pragma once

#include <memory>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/optional_chunks.h"
#include "t4d/file.h"

namespace t4d::formats {

/// The file of a T4dReader: one file, or a file in parts. Its members are those of T4dReader.
class T4dReader::File {
 public:
  virtual ~File() = default;

  virtual T4dVersion version() const = 0;
  virtual const Metadata& metadata() const = 0;
  virtual bool indexed() const = 0;
  virtual const std::string& name() const = 0;
  virtual std::uint64_t fileBytes() const = 0;
  virtual std::uint32_t fingerprint() const = 0;
  virtual std::uint64_t bytesRead() const = 0;
  virtual std::uint64_t requests() const = 0;
  virtual const std::vector<T4dChunks>& chunks() const = 0;
  virtual const OptionalChunks& optionalChunks() const = 0;
  virtual const BodySummary& summary(std::size_t body) const = 0;
  virtual const model::Source& body(std::size_t index) const = 0;
  virtual std::uint64_t slabOffset(std::size_t body, std::size_t slab) const = 0;
  virtual Result<T4dSlab> slabContents(std::size_t body, std::size_t slab) const = 0;
  virtual const std::optional<Error>& damage() const = 0;
  /// Compares the totals of a body's slabs with its summary.
  virtual Result<void> checkSummary(std::size_t body, const BodySummary& found) const = 0;

  /// Opens one file, whole.
  static Result<std::unique_ptr<File>> openOne(std::unique_ptr<ByteSource> source, T4dOpen how,
                                               const model::Progress& progress,
                                               std::optional<std::uint64_t> maxCells);
  /// Opens a file in parts, by its manifest.
  static Result<std::unique_ptr<File>> openParts(const std::filesystem::path& pathOrUrl,
                                                 T4dOpen how, const model::Progress& progress,
                                                 std::optional<std::uint64_t> maxCells);
};

}  // namespace t4d::formats
