#include "t4d/measure/validate.h"

#include <fmt/format.h>

#include "t4d/formats/t4d/reader.h"

namespace t4d::measure {
namespace {

/// Merges the report of one body into that of all bodies.
void join(MeshReport& all, const MeshReport& one) {
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

Issue issueOf(const Error& error) {
  // `where` is dropped: it gives the file and the offset, and the issue has the offset itself.
  return {"file-damaged", Severity::Error, error.message, {}, error.offset};
}

}  // namespace

Result<T4dValidation> validateT4dFile(const std::filesystem::path& path,
                                      const CheckOptions& options, const model::Progress& progress,
                                      std::optional<std::uint64_t> maxCells) {
  // Reading all bytes is the smaller part of the work.
  constexpr double kBytesShare = 0.2;
  T4dValidation validation;
  const auto part = [&](double from, double to) -> model::Progress {
    if (!progress) return {};
    return [=, &progress](double fraction) { progress(from + fraction * (to - from)); };
  };
  auto reader =
      formats::T4dReader::open(path, formats::T4dOpen::Checked, part(0, kBytesShare), maxCells);
  if (!reader) {
    if (reader.error().code == ErrorCode::Io || reader.error().remedy == Remedy::MoreCells) {
      return pass(reader.error());
    }
    validation.issues.add(issueOf(reader.error()));
    return validation;
  }
  MeshReport all;
  const std::size_t count = reader->bodyCount();
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t body) {
      return kBytesShare +
             (1 - kBytesShare) * static_cast<double>(body) / static_cast<double>(count);
    };
    MeshChecker checker(options);
    if (auto read = reader->readThrough(i, checker, part(at(i), at(i + 1))); !read) {
      if (read.error().code == ErrorCode::Io) return pass(read.error());
      validation.issues.add(issueOf(read.error()));
      return validation;
    }
    MeshReport report = checker.finish();
    const std::string prefix =
        count > 1 ? fmt::format("body '{}': ", reader->metadata().bodies[i].name) : "";
    for (Issue& issue : report.issues.issues) {
      issue.message = prefix + issue.message;
      if (issue.slab && *issue.slab < reader->body(i).slabCount()) {
        issue.offset = reader->slabOffset(i, *issue.slab);
      }
      validation.issues.issues.push_back(std::move(issue));
    }
    validation.issues.errors += report.issues.errors;
    validation.issues.warnings += report.issues.warnings;
    join(all, report);
  }
  validation.mesh = std::move(all);
  return validation;
}

}  // namespace t4d::measure
