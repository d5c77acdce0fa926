#include "formats/t4d/validate.h"

#include <cmath>

#include <fmt/format.h>

#include "formats/t4d/reader.h"

namespace t4d::formats {
namespace {

using model::Issue;
using model::MeshReport;
using model::Severity;

/// Adds what was found in one body to what is known of all.
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

/// The mean vertices of a slab are computed, so bounds agree up to their rounding only.
bool agree(const model::Bounds3& stored, const model::Bounds4& found) {
  constexpr double kRounding = 1e-12;
  const double scale = std::max(stored.min.cwiseAbs().maxCoeff(), stored.max.cwiseAbs().maxCoeff());
  const auto near = [&](const model::Point3& a, const model::Point4& b) {
    return (a - b.head<3>()).cwiseAbs().maxCoeff() <= kRounding * scale;
  };
  return near(stored.min, found.min) && near(stored.max, found.max);
}

void checkSummary(const BodySummary& summary, const MeshReport& report, model::IssueList& issues) {
  const auto wrong = [&](const std::string& message) {
    issues.add({"summary-differs", Severity::Error, message, {}, {}});
  };
  if (summary.vertices != report.vertices || summary.tetrahedra != report.tetrahedra) {
    wrong(fmt::format("the file says {} vertices and {} tetrahedra, it has {} and {}",
                      summary.vertices, summary.tetrahedra, report.vertices, report.tetrahedra));
  }
  if (summary.time.begin != report.time.begin || summary.time.end != report.time.end) {
    wrong(fmt::format("the file says it lasts from {} to {}, it does from {} to {}",
                      summary.time.begin, summary.time.end, report.time.begin, report.time.end));
  }
  if (!agree(summary.bounds, report.bounds)) wrong("the file states other bounds than it has");
}

Issue issueOf(const Error& error) {
  // The place is the file's name and the offset, which the issue has by itself.
  return {"file-damaged", Severity::Error, error.message, {}, error.offset};
}

}  // namespace

Result<T4dValidation> validateT4dFile(const std::filesystem::path& path,
                                      const model::CheckOptions& options,
                                      const model::Progress& progress) {
  // Reading all bytes is the smaller part of the work.
  constexpr double kBytesShare = 0.2;
  T4dValidation validation;
  const auto part = [&](double from, double to) -> model::Progress {
    if (!progress) return {};
    return [=, &progress](double fraction) { progress(from + fraction * (to - from)); };
  };
  if (auto checked = checkT4dFile(path, part(0, kBytesShare)); !checked) {
    if (checked.error().code == ErrorCode::Io) return pass(checked.error());
    validation.issues.add(issueOf(checked.error()));
    return validation;
  }
  auto reader = T4dReader::open(path);
  if (!reader) return pass(reader.error());
  MeshReport all;
  const std::size_t count = reader->bodyCount();
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t body) {
      return kBytesShare +
             (1 - kBytesShare) * static_cast<double>(body) / static_cast<double>(count);
    };
    auto report = checkMesh(reader->body(i), options, part(at(i), at(i + 1)));
    if (!report) {
      validation.issues.add(issueOf(report.error()));
      return validation;
    }
    checkSummary(reader->summary(i), *report, report->issues);
    const std::string prefix =
        count > 1 ? fmt::format("body '{}': ", reader->metadata().bodies[i]) : "";
    for (Issue& issue : report->issues.issues) {
      issue.message = prefix + issue.message;
      if (issue.slab && *issue.slab < reader->body(i).slabCount()) {
        issue.offset = reader->slabOffset(i, *issue.slab);
      }
      validation.issues.issues.push_back(std::move(issue));
    }
    validation.issues.errors += report->issues.errors;
    validation.issues.warnings += report->issues.warnings;
    join(all, *report);
  }
  validation.mesh = std::move(all);
  return validation;
}

}  // namespace t4d::formats
