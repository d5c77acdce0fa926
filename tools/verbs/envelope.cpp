#include "tools/verbs/envelope.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "edit/collision_mesh.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/voxel_size.h"
#include "platform/stopwatch.h"
#include "t4d/surface.h"
#include "tools/verbs/body_files.h"
#include "tools/verbs/body_passage.h"
#include "tools/verbs/input_identity.h"
#include "tools/verbs/origin.h"
#include "tools/verbs/visit_field_files.h"
#include "voxel4d/point_field.h"

namespace t4d::verbs {
namespace {

bool isSinglePrecision(const std::string& output) {
  const auto* format = formats::triangleMeshFormat(output);
  return format != nullptr && (format->placed || format->extension == ".stl");
}

model::Bounds3 boundsOf(const Passages& passages) {
  model::Bounds3 bounds;
  for (const Passage& one : passages.all) bounds.add(model::boundsOf(one.silhouette.surface));
  return bounds;
}

Result<void> checkEnvelopeOptions(const EnvelopeOptions& options) {
  const bool perBody = isPerBody(options.output);
  const char* contradiction =
      perBody && !options.each               ? "a file per body needs an envelope of each"
      : options.each && options.fields.any() ? "fields are of all bodies together, not of each"
      : options.exact && options.contains()
          ? "an envelope that contains the motion for certain is made on a lattice, not exactly"
      : options.part && (!options.output.empty() || options.each || options.exact ||
                         options.contains() || options.center)
          ? "parts are of the fields alone: the surface is that of the whole motion"
      : options.part && !options.fields.any() ? "a part of the fields needs a field"
                                              : nullptr;
  if (contradiction != nullptr) return fail(ErrorCode::Options, contradiction);
  if (const auto misuse = misuseOfPerBody(options.output)) return fail(ErrorCode::Options, *misuse);
  return {};
}

edit::EnvelopeOptions latticeOptions(const EnvelopeOptions& options) {
  return {.voxelSize = options.voxelSize.value_or(0),
          .maxBytes = options.memory,
          .exact = options.exact};
}

/// The lattice of the fields, the same as that of the envelope.
Result<measure::SpaceLattice> fieldLattice(const Passages& passages, const EnvelopeOptions& options,
                                           const edit::EnvelopeOptions& how) {
  if (options.voxelSize) {
    if (auto sized = model::checkVoxelSize(*options.voxelSize); !sized) {
      return inInput(sized.error(), passages.input);
    }
  }
  const double voxelSize = options.voxelSize
                               ? *options.voxelSize
                               : edit::defaultVoxelSize(passages.all.front().silhouette, how);
  auto lattice = measure::SpaceLattice::about(boundsOf(passages), voxelSize);
  if (!lattice) return inInput(lattice.error(), passages.input);
  return lattice;
}

/// The lattice of a part of the fields.
Result<measure::SpaceLattice> partLattice(const Passages& passages,
                                          const EnvelopeOptions& options) {
  if (boundsOf(passages).empty()) {
    return invalid("passes through nothing, so there are no fields", passages.input.name);
  }
  return fieldLattice(passages, options, latticeOptions(options));
}

/// What is the same in all parts of the fields of a run, by name.
std::map<std::string, std::string> fieldRunOf(const Passages& passages,
                                              const EnvelopeOptions& options) {
  const Input& input = passages.input;
  std::map<std::string, std::string> run = {{"version of t4d", options.generator},
                                            {"first time", fmt::format("{}", passages.span.begin)},
                                            {"last time", fmt::format("{}", passages.span.end)}};
  const nlohmann::ordered_json identity = identityOf(input);
  for (const auto& [name, number] : identity.items()) run["input's " + name] = number.dump();
  auto names = nlohmann::ordered_json::array();
  for (const model::Body& body : input.bodies) names.push_back(body.name);
  run["list of bodies"] = names.dump();
  return run;
}

/// Writes the fields that are asked for, or the part of them.
Result<void> writeFields(const EnvelopeOptions& options, measure::SpaceLattice lattice,
                         EnvelopeReport& report, Observer& observer) {
  const Passages& passages = report.passages;
  const Input& input = passages.input;
  report.fieldVoxelSize = lattice.spacing;
  VisitFieldWork work = {.lattice = std::move(lattice),
                         .part = options.part.value_or(model::Part())};
  if (options.part) work.run = fieldRunOf(passages, options);
  work.put = [&](model::Sink& fields) -> Result<void> {
    const auto stage = observer.stage("counting visits", slabCountOf(input.bodies), "slabs");
    for (const model::Body& body : input.bodies) {
      auto put = putWithin(body, options.window, passages.span, fields,
                           stage->part(body.source->slabCount()));
      if (!put) return put;
    }
    return {};
  };
  auto written = writeVisitFields(options.fields, work, observer);
  if (!written) return inInput(written.error(), input);
  report.fields = std::move(*written);
  return {};
}

/// Names the file of each passage.
Result<void> nameFiles(const EnvelopeOptions& options, std::vector<Passage>& all) {
  if (!isPerBody(options.output)) {
    for (Passage& one : all) one.file = options.output;
    return {};
  }
  std::vector<std::string> names;
  for (const Passage& one : all) names.push_back(one.name);
  const auto files = bodyFiles(options.output, names);
  if (!files) return files.error();
  for (std::size_t i = 0; i < all.size(); ++i) all[i].file = (*files)[i].string();
  return {};
}

/// The remedy where an envelope cannot be made.
Remedy remedyOf(const Error& error, const Passage& one, const EnvelopeOptions& options,
                const edit::EnvelopeOptions& how) {
  if (error.remedy == Remedy::VoxelSize && !options.contains()) {
    return !options.exact && one.hasFewTriangles() ? Remedy::VoxelSizeOrExact
                                                   : Remedy::VoxelSizeOrOutside;
  }
  if (error.remedy != Remedy::None) return error.remedy;
  if (options.exact) return Remedy::NotExact;
  return how.singlePrecisionAbout && !options.center ? Remedy::Center : Remedy::None;
}

Result<void> makeEnvelope(Passage& one, const EnvelopeOptions& options, edit::EnvelopeOptions how,
                          Observer& observer) {
  const auto stage = observer.stage("making the envelope of " + one.name);
  if (options.contains()) how.reach = one.chordBound.value_or(0) + options.inflate.value_or(0);
  auto envelope = options.simplify ? edit::collisionMeshOf(one.silhouette, how, *options.simplify,
                                                           stage->callback())
                                   : edit::envelopeOf(one.silhouette, how, stage->callback());
  if (!envelope) {
    Error error = envelope.error();
    error.remedy = remedyOf(error, one, options, how);
    return error;
  }
  one.envelope = std::move(*envelope);
  return {};
}

Result<std::vector<std::string>> writeEnvelopes(const EnvelopeOptions& options,
                                                const std::vector<Passage>& all,
                                                const model::Point3& center,
                                                const formats::Metadata& metadata,
                                                Observer& observer) {
  std::vector<formats::NamedMesh> meshes;
  for (const Passage& one : all) meshes.push_back({one.name, one.envelope.mesh});
  formats::MeshWriteOptions how;
  how.origin = originOf(metadata);
  how.center = center;
  const auto* format = formats::triangleMeshFormat(options.output);
  if (format != nullptr && format->placed) {
    std::vector<std::string> notices;
    how.placement = placementOf(metadata, notices);
    for (const std::string& notice : notices) observer.note(notice);
  }
  const auto stage = observer.stage("writing " + options.output);
  if (!isPerBody(options.output)) return formats::writeTriangleMeshes(options.output, meshes, how);
  std::vector<std::filesystem::path> files;
  for (const Passage& one : all) files.emplace_back(one.file);
  return formats::writeEachTriangleMesh(files, meshes, how);
}

Result<void> makePart(const EnvelopeOptions& options, EnvelopeReport& report, Observer& observer) {
  const Passages& passages = report.passages;
  auto lattice = partLattice(passages, options);
  if (!lattice) return lattice.error();
  const std::uint64_t most = voxel4d::mostFieldParts(lattice->at[0].size());
  if (options.part->count > most) {
    return fail(ErrorCode::Options,
                fmt::format("there are {} blocks of 8 planes along x, too few for {} parts", most,
                            options.part->count),
                passages.input.name);
  }
  const auto fits = checkFields(*lattice, *options.part, options.memory);
  if (!fits) return inInput(fits.error(), passages.input);
  return writeFields(options, std::move(*lattice), report, observer);
}

/// Makes envelopes, with fields if they are asked for.
Result<void> makeWhole(const EnvelopeOptions& options, EnvelopeReport& report, Observer& observer) {
  Passages& passages = report.passages;
  const Input& input = passages.input;
  if (auto named = nameFiles(options, passages.all); !named) return named;
  const model::Bounds3 bounds = boundsOf(passages);
  const model::Point3 center =
      options.center ? roundCenterOf(bounds) : model::Point3(model::Point3::Zero());
  edit::EnvelopeOptions how = latticeOptions(options);
  if (isSinglePrecision(options.output)) how.singlePrecisionAbout = center;
  std::optional<measure::SpaceLattice> lattice;
  if (options.fields.any() && !bounds.empty()) {
    auto made = fieldLattice(passages, options, how);
    if (!made) return made.error();
    const auto fits = checkFields(*made, {}, options.memory);
    if (!fits) return inInput(fits.error(), input);
    lattice = std::move(*made);
  }
  for (Passage& one : passages.all) {
    if (auto made = makeEnvelope(one, options, how, observer); !made) {
      return inInput(made.error(), input);
    }
  }
  if (!options.output.empty()) {
    auto written = writeEnvelopes(options, passages.all, center, input.metadata, observer);
    if (!written) return written.error();
    report.fileLosses = std::move(*written);
  }
  return lattice ? writeFields(options, std::move(*lattice), report, observer) : Result<void>();
}

}  // namespace

Result<std::uint64_t> mostFieldParts(const Passages& passages, const EnvelopeOptions& options) {
  const auto lattice = partLattice(passages, options);
  if (!lattice) return lattice.error();
  return voxel4d::mostFieldParts(lattice->at[0].size());
}

std::optional<double> Passage::outsideBy() const {
  if (!chordBound) return std::nullopt;
  return envelope.errorBound + *chordBound;
}

bool Passage::hasFewTriangles() const {
  constexpr std::size_t kFew = 500;  // a thousand may take minutes
  return silhouette.surface.triangles.size() <= kFew;
}

std::vector<std::string> EnvelopeReport::losses() const {
  std::vector<std::string> all;
  for (const Passage& one : passages.all) {
    std::vector<std::string> own = one.envelope.losses;
    if (options.contains() && !one.chordBound) {
      own.emplace_back(
          "it is certain for the mesh as it is, straight between its layers: how far "
          "that is from the motion is not known");
    }
    for (const std::string& loss : own) {
      all.push_back(passages.all.size() > 1 ? fmt::format("{}: {}", one.name, loss) : loss);
    }
  }
  all.insert(all.end(), fileLosses.begin(), fileLosses.end());
  return all;
}

Result<EnvelopeReport> envelope(Passages passages, const EnvelopeOptions& options,
                                Observer& observer) {
  const platform::Stopwatch stopwatch;
  if (auto good = checkEnvelopeOptions(options); !good) return good.error();
  EnvelopeReport report{.passages = std::move(passages), .options = options};
  const auto done =
      options.part ? makePart(options, report, observer) : makeWhole(options, report, observer);
  if (!done) return done.error();
  report.seconds = stopwatch.seconds();
  return report;
}

Result<EnvelopeReport> envelope(const Input& input, const EnvelopeOptions& options,
                                Observer& observer) {
  const platform::Stopwatch stopwatch;
  auto passages = passagesOf(input, options, observer);
  if (!passages) return passages.error();
  for (const Passage& one : passages->all) {
    if (const auto doubt = doubtOfHypervolume(one, passages->span)) observer.note(*doubt);
  }
  auto report = envelope(std::move(*passages), options, observer);
  if (report) report->seconds = stopwatch.seconds();
  return report;
}

}  // namespace t4d::verbs
