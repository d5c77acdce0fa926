#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/metadata.h"
#include "model/slab.h"

namespace t4d::formats {

class OptionalChunks;

struct T4dWriteOptions {
  /// zstd level, 1 to 19; 0 stores arrays as they are.
  int compression = 3;
  /// Store positions as 32-bit floats. Times stay 64-bit, so that slabs still join.
  bool float32 = false;
  /// End the file with an index and a footer, so that a reader finds a slab without reading
  /// everything before it.
  bool index = true;
  /// Store positions as whole numbers on a grid of this step: at most half of it off on each axis.
  /// Not with float32.
  std::optional<double> step = {};
  /// Number of slabs after which connectivity and the reference of posed layers are stored again,
  /// so that damage to one copy costs no more slabs than this; at least 2, or 0 for no copies.
  std::uint64_t spareEvery = 0;
  /// Slabs in a page of the index, at least 1. A file with eight times as many has pages.
  std::size_t pageSlabs = 2048;
};

/// Writes a .t4d file slab by slab. Memory use is one slab, plus some MB for the index, of which
/// the rest waits in a temporary file; of a slab that is made piece by piece (model::StreamedSlab),
/// what is stored of it, unless positions are rounded. Blocks are compressed on all threads. The
/// target path stays untouched until `finish` returns successfully.
///
/// Connectivity is stored once for consecutive slabs of one body that share the object, and where
/// one of the last 4 MiB, and 16 for each body, of stored connectivity has the same content; layers
/// are stored once; means are not stored. Layers that are a reference moved (Slab::upperPose) are
/// stored as the reference and the pose if that gives them to the bit. They are then not rounded to
/// a grid; with float32, reference and result are rounded.
class T4dWriter {
 public:
  /// Fails if body names are invalid or the file cannot be opened.
  static Result<T4dWriter> create(const std::filesystem::path& path, const Metadata& metadata,
                                  const T4dWriteOptions& options = {});

  T4dWriter(T4dWriter&&) noexcept;
  T4dWriter& operator=(T4dWriter&&) noexcept;
  ~T4dWriter();

  /// Takes the slabs of one body in time order; bodies may alternate. Rejects a slab that is
  /// invalid (checkSlab), whose lower layer does not equal the last upper layer of the body, or
  /// whose means differ from those its connectivity defines; the same goes for attributes of
  /// vertices, to the bit. -0 equals 0, and the file keeps the sign of the upper layer. The sink is
  /// valid as long as the writer.
  model::Sink& body(std::size_t index) const;

  /// Copies chunks of the file that is edited which this version does not know, as far as they may
  /// be copied (SPEC.md, section "Editors"); losses() names the others. Call after the first slab.
  Result<void> keep(const OptionalChunks& chunks);

  /// A line if rounding has made cells flat or turned them over, and for each type of chunks that
  /// were not kept; empty otherwise.
  std::vector<std::string> losses() const;

  /// Writes the end of the file and moves it to its path. Fails if a body has no slab, or is so
  /// small that its hypervolume vanishes in doubles. Returns the
  /// size of the file in bytes.
  Result<std::uint64_t> finish();

 private:
  class File;
  explicit T4dWriter(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

}  // namespace t4d::formats
