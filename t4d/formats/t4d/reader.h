#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "t4d/formats/t4d/metadata.h"
#include "t4d/formats/t4d/summary.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

enum class T4dOpen : std::uint8_t {
  /// The file must be whole. One with an index is opened by its footer and index alone; one written
  /// without is read through from the front.
  Whole,
  /// The same, but every byte is read and judged: all chunks with their checksums and order, and
  /// that index and footer say the same.
  Checked,
  /// Read from the front whatever the footer says, up to the first damage; what lies before it can
  /// be used.
  FromFront,
};

struct T4dVersion {
  std::uint16_t major = 0;
  std::uint16_t minor = 0;
};

/// Reads a .t4d file slab by slab; memory is that of a slab or two. Every number from the file is
/// checked before it is used, every slab against its checksums before it is given out.
///
/// Whatever the file, reading takes at most kMemoryPerFileByte bytes for each of its bytes, and
/// kMemoryAlways. The worst is one compressed layer of float32 below and above a slab: 12 bytes for
/// a vertex, 1,024 of them from one byte of the file, become 32 bytes in two places, and half as
/// much again while the next slab is read. A file with nothing compressed takes a hundredth of
/// that.
class T4dReader {
 public:
  static constexpr std::size_t kMemoryPerFileByte = 9 * 1024;
  static constexpr std::size_t kMemoryAlways = std::size_t{1} << 20;

  static Result<T4dReader> open(const std::filesystem::path& path, T4dOpen how = T4dOpen::Whole,
                                const model::Progress& progress = {});

  T4dReader(T4dReader&&) noexcept;
  T4dReader& operator=(T4dReader&&) noexcept;
  ~T4dReader();

  T4dVersion version() const;
  const Metadata& metadata() const;
  bool indexed() const;
  std::uint64_t fileBytes() const;
  /// Bytes read from the file so far.
  std::uint64_t bytesRead() const;

  std::size_t bodyCount() const;
  /// What the file says of a body, without reading its slabs. For a damaged file the slabs found.
  const BodySummary& summary(std::size_t body) const;
  /// The slabs of a body; lives as long as the reader.
  const model::Source& body(std::size_t index) const;
  /// Gives all slabs of a body to `sink`, then holds what the file says of the body against them.
  Result<void> readThrough(std::size_t body, model::Sink& sink,
                           const model::Progress& progress = {}) const;
  /// Where a slab's chunk is in the file.
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const;

  /// With FromFront: what ended the reading before the end of the file.
  const std::optional<Error>& damage() const;

 private:
  class File;
  explicit T4dReader(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// Judges a file by all rules of SPEC.md: every byte, every slab, every sum. Whether the slabs are
/// closed and oriented is measure::MeshChecker's to judge.
Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress = {});

}  // namespace t4d::formats
