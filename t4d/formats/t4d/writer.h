#pragma once

#include <filesystem>
#include <memory>

#include "t4d/formats/t4d/metadata.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

struct T4dWriteOptions {
  /// zstd level, 1 to 19; 0 stores arrays as they are.
  int compression = 3;
  /// Store positions as 32-bit floats. Times stay 64-bit, so that slabs still join.
  bool float32 = false;
  /// End the file with an index and a footer, so that a reader finds a slab without reading the
  /// rest.
  bool index = true;
};

/// Writes a .t4d file slab by slab. Memory is that of a slab and 64 bytes for each slab written.
/// Nothing is at the target path until `finish` returns; without it nothing ever is.
///
/// Connectivity is stored once for slabs in a row of one body that share the object; layers are
/// stored once; means are not stored.
class T4dWriter {
 public:
  /// Refuses bodies that are not well named; fails where the file cannot be opened.
  static Result<T4dWriter> create(const std::filesystem::path& path, const Metadata& metadata,
                                  const T4dWriteOptions& options = {});

  T4dWriter(T4dWriter&&) noexcept;
  T4dWriter& operator=(T4dWriter&&) noexcept;
  ~T4dWriter();

  /// Takes the slabs of one body in time order; bodies may take turns. A slab is refused that is
  /// not sound (checkSlab), whose lower layer does not equal the last upper layer of the body, or
  /// whose means are not what its connectivity says. -0 equals 0, and the file has the upper
  /// layer's sign. The sink lives as long as the writer.
  model::Sink& body(std::size_t index);

  /// Writes the end of the file and puts it in its place. Fails where a body has no slab. Returns
  /// the number of bytes of the file.
  Result<std::uint64_t> finish();

 private:
  class File;
  explicit T4dWriter(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

}  // namespace t4d::formats
