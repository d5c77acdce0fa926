#include "tools/t4d/validate_parts.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/chunks.h"
#include "measure/components.h"
#include "measure/mesh_parts.h"
#include "model/orderless_sum.h"
#include "model/progress.h"
#include "model/source_part.h"
#include "t4d/file.h"
#include "tools/t4d/exact_json.h"
#include "tools/t4d/members.h"

namespace t4d::tools {
namespace {

using measure::Issue;
using measure::MeshReport;
using measure::PartOfMesh;
using model::OrderlessSum;
using nlohmann::ordered_json;

/// The part, with the reason why the file cannot be read further; or an error that is not the
/// file's fault.
Result<PartValidation> broken(const Error& error, const std::filesystem::path& file,
                              PartValidation part, bool beforeAll) {
  const bool nobodysFault = error.code == ErrorCode::Io || error.code == ErrorCode::Failed;
  if (nobodysFault || error.remedy == Remedy::MoreCells) return error;
  part.damage = damageOf(error, file);
  part.beforeAll = beforeAll;
  return part;
}

Result<PartOfMesh> check(const model::Source& source, const model::PartRange& range,
                         measure::CheckOptions options, const model::Progress& progress) {
  options.goesOnBefore = range.begin > 0;
  options.goesOnAfter = range.end < source.slabCount();
  measure::MeshChecker checker(options);
  if (range.begin > 0) {
    const auto before = source.slab(range.begin - 1);
    if (!before) return before.error();
    if (auto begun = checker.startAfter(**before, range.begin - 1); !begun) {
      return begun.error();
    }
  }
  const model::SourcePart share(source, range.begin, range.end);
  if (auto done = model::pump(share, checker, progress); !done) return done.error();
  return checker.finishPart();
}

void describeIssue(Members& members, const Issue& issue) {
  members(
      "code", issue.code,
      "What was found; the page docs/validate.md says what to do about it. A code never changes "
      "its meaning.")
      .oneOf({"file-damaged", "no-cells", "facet-not-shared-by-two", "facet-orientation",
              "inside-out", "seam-differs", "slab-times", "vertex-link", "cap-vertex-link",
              "degenerate-cell"});
  members("severity", static_cast<int>(issue.severity),
          "0 error, 1 warning (cap-vertex-link, degenerate-cell), 2 information, 3 hint.")
      .atLeast(0)
      .atMost(3);
  members("message", issue.message, "In words, with the cell, facet or vertex.").notEmpty();
  members("slab", issue.slab, "Slab of its body, counted from 0; null if there is none.");
  members("offset", issue.offset, "Byte of the file; null if there is none.");
}

template <class T>
std::optional<T> optionalOf(const ordered_json& value) {
  if (value.is_null()) return std::nullopt;
  return value.get<T>();
}

Issue issueOf(const ordered_json& value) {
  return {value.at("code"), static_cast<measure::Severity>(value.at("severity").get<int>()),
          value.at("message"), optionalOf<std::uint64_t>(value.at("slab")),
          optionalOf<std::uint64_t>(value.at("offset"))};
}

template <class Point>
ordered_json exactPoint(const Point& point) {
  auto values = ordered_json::array();
  for (const double value : point) values.push_back(exact(value));
  return values;
}

template <class Bounds>
ordered_json boundsJson(const Bounds& bounds) {
  return {exactPoint(bounds.min), exactPoint(bounds.max)};
}

template <class Bounds>
void readBounds(const ordered_json& value, Bounds& bounds) {
  for (Eigen::Index i = 0; i < bounds.min.size(); ++i) {
    bounds.min[i] = exactDouble(value.at(0).at(static_cast<std::size_t>(i)));
    bounds.max[i] = exactDouble(value.at(1).at(static_cast<std::size_t>(i)));
  }
}

ordered_json termsOf(const OrderlessSum& sum) {
  auto terms = ordered_json::array();
  for (const double term : sum.terms()) terms.push_back(exact(term));
  return terms;
}

OrderlessSum sumOf(const ordered_json& terms) {
  OrderlessSum sum;
  for (const ordered_json& term : terms) sum.add(exactDouble(term));
  return sum;
}

ordered_json jsonOf(const PartValidation::Body& body) {
  const MeshReport& found = body.part.found;
  const measure::ComponentSpan& span = body.part.components;
  auto issues = ordered_json::array();
  for (const Issue& issue : found.issues.issues)
    issues.push_back(Members::valueOf(issue, describeIssue));
  return {{"name", body.name},
          {"said",
           {{"vertices", body.said.vertices},
            {"tetrahedra", body.said.tetrahedra},
            {"bounds", boundsJson(body.said.bounds)}}},
          {"slabs", found.slabs},
          {"vertices", found.vertices},
          {"tetrahedra", found.tetrahedra},
          {"time", {exact(found.time.begin), exact(found.time.end)}},
          {"bounds", boundsJson(found.bounds)},
          {"closed", found.closed},
          {"oriented", found.oriented},
          {"degenerate_cells", found.degenerateCells},
          {"vertex_links_ok", orNull(found.vertexLinksOk)},
          {"hypervolume", termsOf(body.part.hypervolume)},
          {"hypervolume_magnitude", termsOf(body.part.hypervolumeMagnitude)},
          {"boundary_volume", termsOf(body.part.boundaryVolume)},
          {"signs", {body.part.hasNegative, body.part.hasPositive}},
          {"components",
           {{"inside", span.inside},
            {"classes", span.classes},
            {"of_first", span.ofFirst},
            {"of_last", span.ofLast}}},
          {"errors", found.issues.errors},
          {"warnings", found.issues.warnings},
          {"issues", std::move(issues)}};
}

PartValidation::Body bodyOf(const ordered_json& value) {
  PartValidation::Body body;
  body.name = value.at("name");
  body.said.vertices = value.at("said").at("vertices");
  body.said.tetrahedra = value.at("said").at("tetrahedra");
  readBounds(value.at("said").at("bounds"), body.said.bounds);
  MeshReport& found = body.part.found;
  found.slabs = value.at("slabs");
  found.vertices = value.at("vertices");
  found.tetrahedra = value.at("tetrahedra");
  found.time = {exactDouble(value.at("time").at(0)), exactDouble(value.at("time").at(1))};
  readBounds(value.at("bounds"), found.bounds);
  found.closed = value.at("closed");
  found.oriented = value.at("oriented");
  found.degenerateCells = value.at("degenerate_cells");
  found.vertexLinksOk = optionalOf<bool>(value.at("vertex_links_ok"));
  body.part.hypervolume = sumOf(value.at("hypervolume"));
  body.part.hypervolumeMagnitude = sumOf(value.at("hypervolume_magnitude"));
  body.part.boundaryVolume = sumOf(value.at("boundary_volume"));
  body.part.hasNegative = value.at("signs").at(0);
  body.part.hasPositive = value.at("signs").at(1);
  const ordered_json& span = value.at("components");
  body.part.components = {span.at("inside"), span.at("classes"), span.at("of_first"),
                          span.at("of_last")};
  measure::IssueList kept;
  for (const ordered_json& issue : value.at("issues")) kept.add(issueOf(issue));
  kept.errors = value.at("errors");
  kept.warnings = value.at("warnings");
  found.issues = std::move(kept);
  return body;
}

}  // namespace

Result<PartValidation> validatePart(const std::filesystem::path& path,
                                    const measure::CheckOptions& options, const model::Part& part,
                                    const model::Progress& progress,
                                    std::optional<std::uint64_t> maxCells) {
  if (formats::isPipe(path)) {
    return fail(ErrorCode::Options, "a pipe is read from the front; a part needs a file", path);
  }
  const auto how = part.isFirst() ? formats::T4dOpen::Checked : formats::T4dOpen::Whole;
  auto reader = formats::T4dReader::open(path, how, {}, maxCells);
  if (!reader) return broken(reader.error(), path, {}, /*beforeAll=*/true);
  std::uint64_t most = 0;
  std::uint64_t slabs = 0;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    most = std::max<std::uint64_t>(most, reader->body(i).slabCount());
    slabs += part.of(reader->body(i).slabCount()).size();
  }
  if (most < part.count) {
    return fail(ErrorCode::Options,
                fmt::format("has {} slabs, too few for {} parts", most, part.count),
                reader->name());
  }
  PartValidation validation;
  std::uint64_t done = 0;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    const model::Source& source = reader->body(i);
    const model::PartRange range = part.of(source.slabCount());
    const auto share = [&](std::uint64_t all) { return double(all) / double(slabs); };
    auto found = check(source, range, options,
                       model::partOf(progress, share(done), share(done + range.size())));
    if (!found) return broken(found.error(), path, std::move(validation), /*beforeAll=*/false);
    for (Issue& issue : found->found.issues.issues) {
      if (issue.slab && *issue.slab < source.slabCount()) {
        issue.offset = reader->slabOffset(i, *issue.slab);
      }
    }
    validation.bodies.push_back(
        {reader->metadata().bodies[i].name, std::move(*found), reader->summary(i)});
    done += range.size();
  }
  return validation;
}

Validation validationOf(const PartValidation& part) {
  Validation validation;
  for (const PartValidation::Body& body : part.bodies) {
    addBody(validation, body.part.found, body.name, part.bodies.size());
  }
  if (part.damage) {
    validation.mesh.reset();
    validation.issues.add(*part.damage);
  }
  return validation;
}

Result<Validation> joinedValidation(const std::vector<PartValidation>& parts) {
  Validation validation;
  std::size_t bodies = 0;
  for (const PartValidation& part : parts) bodies = std::max(bodies, part.bodies.size());
  const auto damaged = [&](const Issue& issue) {
    validation.mesh.reset();
    validation.issues.add(issue);
    return validation;
  };
  const auto first = std::ranges::find_if(parts, &PartValidation::beforeAll);
  if (first != parts.end()) return damaged(*first->damage);
  for (std::size_t i = 0; i <= bodies; ++i) {
    std::vector<PartOfMesh> ofBody;
    for (const PartValidation& part : parts) {
      if (i < part.bodies.size()) {
        ofBody.push_back(part.bodies[i].part);
      } else if (part.damage) {
        return damaged(*part.damage);
      }
    }
    if (i == bodies) break;
    if (ofBody.size() < parts.size()) return invalid("the parts do not have the same bodies");
    const PartValidation::Body& body = parts.front().bodies[i];
    auto report = measure::joinedReport(ofBody);
    if (!report) return report.error();
    formats::BodySummary found;
    found.vertices = report->vertices;
    found.tetrahedra = report->tetrahedra;
    found.bounds.min = report->bounds.min.head<3>();
    found.bounds.max = report->bounds.max.head<3>();
    if (auto same = formats::checkSummary(body.said, found); !same) {
      Error error = same.error();
      error.message = fmt::format("DONE: body {}: {}", i, error.message);
      return damaged(damageOf(error, {}));
    }
    addBody(validation, std::move(*report), body.name, bodies);
  }
  return validation;
}

void describe(Members& members, const Validation& validation) {
  const auto ofMesh = [&](auto member) {
    return validation.mesh ? std::optional((*validation.mesh).*member) : std::nullopt;
  };
  // A mesh with gaps, or with sides that disagree, encloses nothing in particular.
  const bool encloses = validation.mesh && validation.mesh->closed && validation.mesh->oriented;
  members("valid", validation.valid(), "There are no errors.");
  members("closed", ofMesh(&MeshReport::closed), "Every facet has exactly two cells.");
  members("oriented", ofMesh(&MeshReport::oriented),
          "The two cells of every facet are on opposite sides of it.");
  members("hypervolume", encloses ? ofMesh(&MeshReport::hypervolume) : std::nullopt,
          "Enclosed, in length units to the third times time units. Also null if the mesh is not "
          "closed and oriented, or if it is too large for a double.");
  members(
      "boundary_volume", ofMesh(&MeshReport::boundaryVolume),
      "Of all cells, in length units to the third, taking one time unit as one length unit. Also "
      "null if it is too large for a double.")
      .atLeast(0);
  members("components", ofMesh(&MeshReport::components), "Connected components.");
  members("degenerate_cells", ofMesh(&MeshReport::degenerateCells),
          "Cells without volume within the rounding of their corners.");
  members("vertex_links_ok", validation.mesh ? validation.mesh->vertexLinksOk : std::nullopt,
          "Every vertex link is a sphere. With --deep only.")
      .onlyIf(validation.deep);
  members("issues", validation.issues, "All findings.",
          [](Members& own, const measure::IssueList& issues) {
            own("errors", issues.errors, "Number, including those that are not in messages.");
            own("warnings", issues.warnings, "Number, including those that are not in messages.");
            own("messages", issues.issues, "The first ten findings of each code and body.",
                describeIssue);
          });
}

ordered_json stateOf(const PartValidation& part) {
  ordered_json state = {{"bodies", ordered_json::array()},
                        {"damage", Members::valueOf(part.damage, describeIssue)},
                        {"before_all", part.beforeAll}};
  for (const PartValidation::Body& body : part.bodies) state["bodies"].push_back(jsonOf(body));
  return state;
}

std::optional<PartValidation> partValidationOf(const ordered_json& state) {
  try {
    PartValidation part;
    for (const ordered_json& body : state.at("bodies")) part.bodies.push_back(bodyOf(body));
    if (!state.at("damage").is_null()) part.damage = issueOf(state.at("damage"));
    part.beforeAll = state.at("before_all");
    return part;
  } catch (const ordered_json::exception&) {
    return std::nullopt;
  }
}

}  // namespace t4d::tools
