#include "tools/t4d/validation.h"

#include <deque>
#include <vector>

#include <fmt/format.h>

#include "model/progress.h"
#include "t4d/file.h"

namespace t4d::tools {
namespace {

/// Adds what was found in a body, whose slabs are at these offsets in the file.
template <class OffsetOf>
void add(Validation& validation, measure::MeshReport report, const formats::Metadata& metadata,
         std::size_t body, OffsetOf offsetOf) {
  for (measure::Issue& issue : report.issues.issues) {
    if (issue.slab) issue.offset = offsetOf(*issue.slab);
  }
  addBody(validation, std::move(report), metadata.bodies[body].name, metadata.bodies.size());
}

/// The result for a file that cannot be read to its end, after `validation` so far.
Result<Validation> broken(const Error& error, const std::filesystem::path& file,
                          Validation validation = {}) {
  const bool nobodysFault = error.code == ErrorCode::Io || error.code == ErrorCode::Failed;
  if (nobodysFault || error.remedy == Remedy::MoreCells) return error;
  validation.mesh.reset();
  validation.issues.add(damageOf(error, file));
  return validation;
}

Result<Validation> validatePipe(const std::filesystem::path& path,
                                const measure::CheckOptions& options,
                                std::optional<std::uint64_t> maxCells) {
  auto stream = formats::T4dStream::open(path, maxCells);
  if (!stream) return broken(stream.error(), path);
  std::deque<measure::MeshChecker> checkers;
  for (std::size_t i = 0; i < stream->bodyCount(); ++i) checkers.emplace_back(options);
  std::vector<std::vector<std::uint64_t>> offsets(checkers.size());
  while (true) {
    const auto item = stream->next();
    if (!item) return broken(item.error(), path);
    if (!*item) break;
    const formats::T4dStream::Item& slab = **item;
    offsets[slab.body].push_back(slab.offset);
    if (auto put = checkers[slab.body].put(*slab.slab); !put) return broken(put.error(), path);
  }
  Validation validation;
  for (std::size_t i = 0; i < checkers.size(); ++i) {
    add(validation, checkers[i].finish(), stream->metadata(), i,
        [&](std::size_t slab) -> std::optional<std::uint64_t> {
          if (slab < offsets[i].size()) return offsets[i][slab];
          return std::nullopt;
        });
  }
  return validation;
}

}  // namespace

measure::Issue damageOf(const Error& error, const std::filesystem::path& file) {
  // The issue has the offset itself.
  const bool elsewhere = !file.empty() && !error.where.empty() && error.where.file != file.string();
  return {"file-damaged",
          measure::Severity::Error,
          elsewhere ? error.text() : error.message,
          {},
          error.offset};
}

void addBody(Validation& validation, measure::MeshReport one, const std::string& name,
             std::size_t bodies) {
  for (measure::Issue& issue : one.issues.issues) {
    if (bodies > 1) issue.message = fmt::format("body '{}': {}", name, issue.message);
    validation.issues.issues.push_back(std::move(issue));
  }
  validation.issues.errors += one.issues.errors;
  validation.issues.warnings += one.issues.warnings;
  if (!validation.mesh) validation.mesh.emplace();
  measure::MeshReport& all = *validation.mesh;
  all.slabs += one.slabs;
  all.vertices += one.vertices;
  all.tetrahedra += one.tetrahedra;
  all.closed = all.closed && one.closed;
  all.oriented = all.oriented && one.oriented;
  all.hypervolume += one.hypervolume;
  all.boundaryVolume += one.boundaryVolume;
  all.components += one.components;
  all.degenerateCells += one.degenerateCells;
  if (one.vertexLinksOk) all.vertexLinksOk = all.vertexLinksOk.value_or(true) && *one.vertexLinksOk;
}

Result<Validation> validate(const std::filesystem::path& path, const measure::CheckOptions& options,
                            const model::Progress& progress,
                            std::optional<std::uint64_t> maxCells) {
  if (formats::isPipe(path)) return validatePipe(path, options, maxCells);
  // Reading all bytes is the smaller part of the work.
  constexpr double kBytesShare = 0.2;
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Checked,
                                         model::partOf(progress, 0, kBytesShare), maxCells);
  if (!reader) return broken(reader.error(), path);
  Validation validation;
  const std::size_t count = reader->bodyCount();
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t body) {
      return kBytesShare +
             (1 - kBytesShare) * static_cast<double>(body) / static_cast<double>(count);
    };
    measure::MeshChecker checker(options);
    auto read = reader->readThrough(i, checker, model::partOf(progress, at(i), at(i + 1)));
    if (!read) return broken(read.error(), path, std::move(validation));
    add(validation, checker.finish(), reader->metadata(), i,
        [&](std::size_t slab) -> std::optional<std::uint64_t> {
          if (slab < reader->body(i).slabCount()) return reader->slabOffset(i, slab);
          return std::nullopt;
        });
  }
  return validation;
}

}  // namespace t4d::tools
