#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/metadata.h"
#include "formats/t4d/summary.h"
#include "model/slab.h"

namespace t4d::formats {

class OptionalChunks;

enum class T4dOpen : std::uint8_t {
  /// The file must be complete. If it has an index, only footer and index are read; otherwise the
  /// file is read through from the front.
  Whole,
  /// As Whole, but every byte is read and checked: the checksums and the order of all chunks, and
  /// that index and footer agree with them.
  Checked,
  /// Read from the front, ignoring the footer, up to the first damage. Everything before it can be
  /// used.
  FromFront,
};

struct T4dVersion {
  std::uint16_t major = 0;
  std::uint16_t minor = 0;
};

/// The most cells, of all slabs together, that a file of this size may have unless its reader
/// allows more: 100 million, and 10,000 for each byte. Slabs may share their connectivity, so that
/// a small file can ask for any amount of work.
std::uint64_t usualCellLimit(std::uint64_t fileBytes);

/// Allows any number of cells.
inline constexpr std::uint64_t kAnyCells = ~std::uint64_t{0};

/// The chunks of one type.
struct T4dChunks {
  std::string type;
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;  ///< with headers and padding
};

/// What a slab contains.
struct T4dSlab {
  model::TimeSpan time;
  std::uint64_t cells = 0;
  model::Bounds3 bounds;  ///< of all its vertices
};

/// Reads a .t4d file slab by slab, with one or two slabs in memory. Every number from the file is
/// checked before it is used, and every slab against its checksums before it is returned.
///
/// For any file, reading takes at most kMemoryPerFileByte bytes per byte of the file, plus
/// kMemoryAlways. The worst case is one compressed float32 layer of which those below and above a
/// slab are poses: 12 bytes per vertex, of which one byte of the file can unpack to 1,024, become
/// 24 bytes in one place and 32 in two, and half as much again while the next slab is read. An
/// uncompressed file takes about one hundredth of that.
class T4dReader {
 public:
  class File;
  static constexpr std::size_t kMemoryPerFileByte = 12 * 1024;
  static constexpr std::size_t kMemoryAlways = std::size_t{1} << 20;

  /// Opens a file by its path, or by its URL on a web server (http:// or https://). There it
  /// requests a part of the file at a time, and fails if the file changes between two requests.
  ///
  /// A path or URL that ends in .t4dm is a file in parts: its manifest is read, and of its parts
  /// those that are asked for. A part is compared with the manifest when it is opened, by its size
  /// and its footer; with Checked, all of them are read and their SHA-256 compared as well.
  ///
  /// Fails for a file with more than `maxCells` cells, which is usualCellLimit if not given. With
  /// FromFront they are not counted.
  static Result<T4dReader> open(const std::filesystem::path& pathOrUrl,
                                T4dOpen how = T4dOpen::Whole, const model::Progress& progress = {},
                                std::optional<std::uint64_t> maxCells = {});

  T4dReader(T4dReader&&) noexcept;
  T4dReader& operator=(T4dReader&&) noexcept;
  ~T4dReader();

  T4dVersion version() const;
  const Metadata& metadata() const;
  bool indexed() const;
  /// For messages: the path, or the URL without credentials.
  const std::string& name() const;
  std::uint64_t fileBytes() const;
  /// Differs for different files, as surely as a checksum of 32 bits can; 0 without an index.
  std::uint32_t fingerprint() const;
  /// Bytes read from the file so far.
  std::uint64_t bytesRead() const;
  /// Requests made to a web server so far; 0 for a local file.
  std::uint64_t requests() const;
  /// By type, in the order in which the types appear.
  const std::vector<T4dChunks>& chunks() const;

  /// The chunks that this version does not know, for T4dWriter::keep; valid as long as the reader.
  const OptionalChunks& optionalChunks() const;

  std::size_t bodyCount() const;
  /// The summary of a body as stored, without reading its slabs. For a damaged file, that of the
  /// slabs found.
  const BodySummary& summary(std::size_t body) const;
  /// The slabs of a body; valid as long as the reader.
  const model::Source& body(std::size_t index) const;
  /// Puts all slabs of a body into `sink`, then checks the file's summary of the body against them.
  Result<void> readThrough(std::size_t body, model::Sink& sink,
                           const model::Progress& progress = {}) const;
  /// The offset of a slab's chunk in the file, or in the part that has it.
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const;

  /// As the index has it; without an index the slab is read.
  Result<T4dSlab> slabContents(std::size_t body, std::size_t slab) const;

  /// With FromFront: why reading stopped before the end of the file.
  const std::optional<Error>& damage() const;

 private:
  explicit T4dReader(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// Checks a file against all rules of SPEC.md: every byte, every slab, every sum. Whether the slabs
/// are closed and oriented is left to measure::MeshChecker. There may be any number of cells.
Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress = {});

}  // namespace t4d::formats
