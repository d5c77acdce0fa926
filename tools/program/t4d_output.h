#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/formats/t4d/writer.h"
#include "t4d/model/transformed.h"

namespace t4d::tools {

/// The last component of a path, also of "frames/" and ".".
std::filesystem::path nameIn(const std::string& path);

/// The name of a file without its extension, or extensions: "brain" of "brain.nii.gz".
std::string nameWithoutExtension(const std::filesystem::path& path);

/// Adds `-o`, the .t4d file to write.
void addT4dOutputOption(CLI::App& command, std::string& path);

/// Adds `--compression`.
void addCompressionOption(CLI::App& command, int& level);

/// How a .t4d file is stored.
struct T4dCoding {
  std::string precision = "float64";
  std::optional<double> grid;
  int compression = 3;
  std::uint64_t spareEvery = 0;

  void addTo(CLI::App& command);
  formats::T4dWriteOptions writeOptions() const;
  /// A line about positions that are rounded, for the report of what was written; or nothing.
  std::optional<std::string> rounding() const;
};

/// The options of every verb that makes a .t4d from something else.
struct T4dOutput {
  std::string path;
  T4dCoding coding;
  std::string up;  ///< "y" or "z"; "" if it is not given
  std::string body;
  bool center = false;

  void addTo(CLI::App& command);
};

/// A .t4d file in the making, with one body or several. With `--center` its slabs are moved, such
/// that the origin is in the middle of the first one; the file says where it was.
class T4dFile : public model::Sink {
 public:
  /// Metadata of the file; the body is named by `--body` or after `model`. `detailsJson` describes
  /// how the file was made.
  struct About {
    std::string backend;
    std::string model;
    std::string lengthUnit;
    std::string timeUnit;
    std::string detailsJson;
    std::vector<formats::BodyInfo> bodies = {};  ///< several bodies
    std::string space = {};                      ///< as formats::Metadata::space; z points up in it
    std::string up = "y";  ///< where `--up` is not given, and there is no space
  };

  static Result<T4dFile> create(const T4dOutput& output, const About& about);

  /// Slabs go to this body from now on; at first, to body 0.
  void setBody(std::size_t index) { body_ = index; }
  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;
  Result<void> putStreamed(const model::StreamedSlab& slab) override;
  /// The size of the file in bytes.
  Result<std::uint64_t> finish();
  /// As formats::T4dWriter::losses.
  std::vector<std::string> losses() const;

 private:
  Result<void> begin(const model::Slab* first);
  model::Sink& sink();

  T4dOutput output_;
  formats::Metadata metadata_;
  std::optional<formats::T4dWriter> writer_;
  std::size_t body_ = 0;
  std::vector<model::Transformed> centred_;  // before each body of the writer, with `--center`
};

}  // namespace t4d::tools
