#include "tools/program/t4d_output.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/voxel4d/volumes/volume_frames.h"
#include "tools/program/centering.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/version.h"

namespace t4d::tools {

std::filesystem::path nameIn(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error).lexically_normal();
  return whole.has_filename() ? whole.filename() : whole.parent_path().filename();
}

std::string nameWithoutExtension(const std::filesystem::path& path) {
  const std::filesystem::path stem = path.filename().stem();
  const std::string both = formats::lowerCaseExtension(stem) + formats::lowerCaseExtension(path);
  const auto formats = voxel4d::volumeFormats();
  const bool isDouble =
      stem.has_extension() &&
      std::ranges::find(formats, both, &voxel4d::VolumeFormat::extension) != formats.end();
  return (isDouble ? stem.stem() : stem).string();
}

void addT4dOutputOption(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, "Output file (.t4d), or - for standard output")
      ->required()
      ->check(someName())
      ->check(noOtherFormat());
}

void addCompressionOption(CLI::App& command, int& level) {
  command.add_option("--compression", level, "zstd level, 1 to 19; 0 stores uncompressed")
      ->check(wholeNumber(0, 19))
      ->capture_default_str();
}

void T4dCoding::addTo(CLI::App& command) {
  auto* precisionOption = command.add_option("--precision", precision, "Precision of positions")
                              ->check(CLI::IsMember({"float64", "float32"}))
                              ->capture_default_str();
  command
      .add_option("--grid-step", grid,
                  "Round positions to multiples of STEP (error per axis up to STEP / 2)")
      ->type_name("STEP")
      ->check(numberAboveZero())
      ->excludes(precisionOption);
  addCompressionOption(command, compression);
  command
      .add_option("--spare-copies", spareEvery,
                  "Repeat shared data every N slabs (at least 2), for recovery; 0: store once")
      ->type_name("N")
      ->check(wholeNumber(0, 1'000'000))
      ->check(noLoneCopy())
      ->capture_default_str();
}

formats::T4dWriteOptions T4dCoding::writeOptions() const {
  return {.compression = compression,
          .float32 = precision == "float32",
          .step = grid,
          .spareEvery = spareEvery};
}

std::optional<std::string> T4dCoding::rounding() const {
  if (!grid) return std::nullopt;
  return fmt::format("positions on a grid of {}: at most {} off along each axis; poses are exact",
                     *grid, *grid / 2);
}

void T4dOutput::addTo(CLI::App& command) {
  addT4dOutputOption(command, path);
  coding.addTo(command);
  command
      .add_option("--up", up, "Axis that points up (default: y, or z if the input is RAS or LPS)")
      ->check(CLI::IsMember({"y", "z"}));
  addCenterOption(command, center);
  command.add_option("--body", body, "Name of the body (default: name of the input file)")
      ->check(someName());
}

Result<T4dFile> T4dFile::create(const T4dOutput& output, const About& about) {
  T4dFile file;
  file.output_ = output;
  formats::Metadata& metadata = file.metadata_;
  metadata.generator = std::string(versionText());
  metadata.backend = about.backend;
  metadata.lengthUnit = about.lengthUnit;
  metadata.timeUnit = about.timeUnit;
  metadata.up = !output.up.empty() ? output.up : about.space.empty() ? about.up : "z";
  metadata.space = about.space;
  metadata.bodies = about.bodies;
  if (metadata.bodies.empty()) {
    metadata.bodies = {{output.body.empty()
                            ? formats::asName(nameWithoutExtension(nameIn(about.model)))
                            : output.body}};
  }
  metadata.detailsJson = about.detailsJson;
  if (!output.center) {
    if (auto begun = file.begin(nullptr); !begun) return begun.error();
  }
  return file;
}

Result<void> T4dFile::begin(const model::Slab* first) {
  std::optional<model::Transform> centring;
  if (first != nullptr) {
    model::Bounds3 bounds;
    for (const model::Point4& vertex : first->vertices) bounds.add(vertex.head<3>());
    const model::Point3 center = roundCenterOf(bounds);
    centring.emplace().space.col(3) = -center;
    metadata_.detailsJson = withOrigin(metadata_.detailsJson, center);
  }
  auto writer = formats::T4dWriter::create(output_.path, metadata_, output_.coding.writeOptions());
  if (!writer) return writer.error();
  writer_ = std::move(*writer);
  for (std::size_t i = 0; centring && i < metadata_.bodies.size(); ++i) {
    centred_.emplace_back(writer_->body(i), *centring);
  }
  return {};
}

model::Sink& T4dFile::sink() { return centred_.empty() ? writer_->body(body_) : centred_[body_]; }

Result<void> T4dFile::put(const model::Slab& slab) {
  if (!writer_) {
    if (auto begun = begin(&slab); !begun) return begun;
  }
  return sink().put(slab);
}

std::unique_ptr<T4dFile::Prepared> T4dFile::prepare(const model::Slab& slab) const {
  // Where the mesh is centred, the first slab must come first.
  return output_.center ? nullptr : writer_->body(body_).prepare(slab);
}

Result<void> T4dFile::putPrepared(const model::Slab& slab, Prepared* prepared) {
  return prepared == nullptr ? put(slab) : writer_->body(body_).putPrepared(slab, prepared);
}

Result<void> T4dFile::putStreamed(const model::StreamedSlab& slab) {
  return writer_ ? sink().putStreamed(slab) : put(assembled(slab));
}

Result<std::uint64_t> T4dFile::finish() {
  if (!writer_) {
    if (auto begun = begin(nullptr); !begun) return begun.error();
  }
  return writer_->finish();
}

std::vector<std::string> T4dFile::losses() const {
  return writer_ ? writer_->losses() : std::vector<std::string>{};
}

}  // namespace t4d::tools
