#include "tools/t4d/t4d_file.h"

#include <algorithm>

#include "formats/file_extension.h"
#include "formats/t4d/names.h"
#include "t4d/frames.h"
#include "tools/t4d/origin.h"
#include "voxel4d/frame_formats.h"

namespace t4d::tools {

std::filesystem::path nameIn(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error).lexically_normal();
  return whole.has_filename() ? whole.filename() : whole.parent_path().filename();
}

std::string nameWithoutExtension(const std::filesystem::path& path) {
  const std::filesystem::path stem = path.filename().stem();
  const std::string both = formats::lowerCaseExtension(stem) + formats::lowerCaseExtension(path);
  const auto known = voxel4d::volumeExtensions();
  const bool isDouble = stem.has_extension() && std::ranges::find(known, both) != known.end();
  return (isDouble ? stem.stem() : stem).string();
}

Result<T4dFile> T4dFile::create(T4dFileOptions options, const About& about) {
  T4dFile file;
  file.options_ = std::move(options);
  const T4dFileOptions& output = file.options_;
  formats::Metadata& metadata = file.metadata_;
  metadata.generator = output.generator;
  metadata.backend = about.backend;
  metadata.lengthUnit = about.lengthUnit;
  metadata.timeUnit = about.timeUnit;
  metadata.up = !output.up.empty() ? output.up : about.space.empty() ? about.up : "z";
  metadata.space = about.space;
  metadata.bodies = about.bodies;
  if (metadata.bodies.empty()) metadata.bodies.emplace_back();
  if (metadata.bodies.front().name.empty()) {
    metadata.bodies.front().name = output.body.empty()
                                       ? formats::asName(nameWithoutExtension(nameIn(about.model)))
                                       : output.body;
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
  auto writer = formats::T4dWriter::create(options_.path, metadata_, options_.writing);
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
  return options_.center ? nullptr : writer_->body(body_).prepare(slab);
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
