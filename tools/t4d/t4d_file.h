#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::tools {

/// The last component of a path, also of "frames/" and ".".
std::filesystem::path nameIn(const std::string& path);

/// The name of a file without its extension, or extensions: "brain" of "brain.nii.gz".
std::string nameWithoutExtension(const std::filesystem::path& path);

/// Options of every verb that makes a .t4d from something else.
struct T4dFileOptions {
  std::string path;
  formats::T4dWriteOptions writing = {};
  std::string up = {};         ///< "y" or "z"; "" for that of the input
  std::string body = {};       ///< "" for one that is named after the input
  bool center = false;         ///< move the middle of the first slab to the origin
  std::string generator = {};  ///< program and version, for the metadata
};

/// A .t4d file in the making, with one body or several. If it is centred, its slabs are moved, such
/// that the origin is in the middle of the first one; the file says where it was.
class T4dFile : public model::Sink {
 public:
  /// Metadata of the file; the body is named by the options or after `model`. `detailsJson`
  /// describes how the file was made.
  struct About {
    std::string backend;
    std::string model;
    std::string lengthUnit;
    std::string timeUnit;
    std::string detailsJson;
    /// Several bodies with names; or one, whose name may be empty.
    std::vector<formats::BodyInfo> bodies = {};
    std::string space = {};  ///< as formats::Metadata::space; z points up in it
    std::string up = "y";    ///< where the options have none, and there is no space
  };

  static Result<T4dFile> create(T4dFileOptions options, const About& about);

  /// Slabs go to this body from now on; at first, to body 0.
  void setBody(std::size_t index) { body_ = index; }
  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;
  Result<void> putStreamed(const model::StreamedSlab& slab) override;
  /// The size of the file in bytes.
  Result<std::uint64_t> finish();
  /// The losses of formats::T4dWriter::losses.
  std::vector<std::string> losses() const;

 private:
  Result<void> begin(const model::Slab* first);
  model::Sink& sink();

  T4dFileOptions options_;
  formats::Metadata metadata_;
  std::optional<formats::T4dWriter> writer_;
  std::size_t body_ = 0;
  std::vector<model::Transformed> centred_;  // before each body of the writer, if they are centred
};

}  // namespace t4d::tools
