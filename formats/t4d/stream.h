#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/reader.h"
#include "platform/file_format.h"

namespace t4d::formats {

/// Our own, in one file or in parts.
std::vector<platform::FileFormat> t4dFormats();

/// Whether the path is `-`, the standard input, or a pipe or terminal: whether T4dStream can read
/// it, and T4dReader cannot.
bool isPipe(const std::filesystem::path& path);

/// Whether the path is a regular file with the signature of .t4d, whatever its name and its damage.
bool isT4d(const std::filesystem::path& path);

/// Reads a .t4d file once, from the front, as it comes through a pipe. Keeps a slab or two in
/// memory, what is stored of the parts that slabs to come may name, and some 300 bytes for each
/// chunk. While a chunk is read it is in memory up to three times as it is stored. Checks
/// all that checkT4dFile does.
class T4dStream {
 public:
  /// Opens a pipe, or any other file; `-` is the standard input. Cells are counted as they come: at
  /// most `maxCells`, or usualCellLimit of the bytes so far if that is not given.
  static Result<T4dStream> open(const std::filesystem::path& path,
                                std::optional<std::uint64_t> maxCells = {});

  T4dStream(T4dStream&&) noexcept;
  T4dStream& operator=(T4dStream&&) noexcept;
  ~T4dStream();

  T4dVersion version() const;
  const Metadata& metadata() const;
  bool indexed() const;
  const std::string& name() const;
  std::size_t bodyCount() const;

  struct Item {
    std::size_t body = 0;
    std::uint64_t offset = 0;  ///< of the slab's chunk
    std::shared_ptr<const model::Slab> slab;
  };
  /// The next slab in the order of the file. Nothing after the last one, when all that follows it
  /// has been read and checked, too.
  Result<std::optional<Item>> next();

  /// Complete when next() has returned nothing.
  std::uint64_t fileBytes() const;
  const std::vector<T4dChunks>& chunks() const;
  const BodySummary& summary(std::size_t body) const;

 private:
  class File;
  explicit T4dStream(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

}  // namespace t4d::formats
