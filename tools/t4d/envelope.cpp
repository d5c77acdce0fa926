#include "tools/t4d/envelope.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "edit/collision_mesh.h"
#include "formats/output_file.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/voxel_size.h"
#include "platform/stopwatch.h"
#include "t4d/slice.h"
#include "t4d/surface.h"
#include "tools/report/solid_picture.h"
#include "tools/t4d/body_files.h"
#include "tools/t4d/body_passage.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/envelope_page.h"
#include "tools/t4d/input.h"
#include "tools/t4d/input_identity.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/time_window.h"
#include "tools/t4d/version.h"
#include "tools/t4d/visit_field_files.h"
#include "voxel4d/point_field.h"

namespace t4d::tools {
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

namespace {

using nlohmann::ordered_json;

struct EnvelopeArguments {
  std::string input;
  InputOptions only;
  TimeWindow window;
  EnvelopeOptions envelope;
  PartOption part;
  std::string html;
  double memory = 4;  // GB
  bool json = false;
};

struct FieldOption {
  const char* option;
  std::string VisitFieldFiles::*file;
  const char* help;
};
constexpr std::array<FieldOption, 4> kFieldOptions = {{
    {"--visits", &VisitFieldFiles::visits, "number of visits of each point, as int32"},
    {"--dwell", &VisitFieldFiles::dwell, "how long each point is covered"},
    {"--first", &VisitFieldFiles::first, "when each point is first covered"},
    {"--last", &VisitFieldFiles::last, "when each point is last covered"},
}};

std::vector<std::string> outputsOf(const EnvelopeArguments& options) {
  std::vector<std::string> outputs = {options.html};
  if (!isPerBody(options.envelope.output)) outputs.push_back(options.envelope.output);
  for (const FieldOption& field : kFieldOptions) {
    outputs.push_back(options.envelope.fields.*field.file);
  }
  std::erase(outputs, "");
  return outputs;
}

/// Why a part of the fields cannot be made with the options.
std::optional<std::string> misuseOfPart(const EnvelopeArguments& options) {
  if (!options.part.isAsked()) return std::nullopt;
  const EnvelopeOptions& how = options.envelope;
  if (!how.output.empty() || !options.html.empty() || how.each || how.exact || how.contains() ||
      how.center) {
    return "--part divides the fields alone, without -o, --html, --each, --exact, --outside, "
           "--inflate, --simplify and --center: the surface is that of the whole motion";
  }
  if (options.part.isGiven() && !how.fields.any()) {
    return "--part divides the fields: give --visits, --dwell, --first or --last";
  }
  return std::nullopt;
}

/// Why the options cannot be.
std::optional<std::string> misuseOf(const EnvelopeArguments& options) {
  const EnvelopeOptions& how = options.envelope;
  if (isPerBody(how.output) && !how.each) {
    return "-o: a file per body, by {body}, needs --each";
  }
  if (auto misuse = misuseOfPerBody(how.output)) return misuse;
  if (how.each && how.fields.any()) {
    return "--each: fields are of all bodies together; choose one by --body";
  }
  if (how.contains() && how.exact) {
    return "--outside, --inflate or --simplify: an envelope that contains the motion for certain "
           "is "
           "made on a lattice, not with --exact";
  }
  return misuseOfPart(options);
}

/// Checks the files of the bodies, whose names are not known before.
Result<void> checkBodyFiles(const EnvelopeArguments& options, const Passages& passages) {
  if (!isPerBody(options.envelope.output)) return {};
  std::vector<std::string> names;
  for (const Passage& one : passages.all) names.push_back(one.name);
  const auto files = bodyFiles(options.envelope.output, names);
  if (!files) return files.error();
  std::vector<std::string> outputs = {options.html};
  for (const auto& file : *files) outputs.push_back(file.string());
  return checkOutputs(outputs);
}

/// Options that find a thin solid, or take less time.
std::string otherWays(const EnvelopeOptions& how, const Passage& one) {
  if (how.contains()) return {};
  return !how.exact && one.hasFewTriangles() ? "--exact or --outside" : "--outside";
}

void printPassages(const EnvelopeReport& report) {
  const EnvelopeOptions& how = report.options;
  const std::vector<Passage>& all = report.passages.all;
  for (const Passage& one : all) {
    const edit::Envelope& envelope = one.envelope;
    const bool several = all.size() > 1;
    const bool perBody = isPerBody(how.output);
    print("{}{}{}, {}, {}; volume {:.12g}\n",
          one.file.empty() || (several && !perBody) ? "" : one.file + ": ",
          several && !perBody ? one.name + ": " : "",
          counted(envelope.mesh.vertices.size(), "vertex", "vertices"),
          counted(envelope.mesh.triangles.size(), "triangle"),
          model::isClosed(envelope.mesh) ? "closed" : "NOT CLOSED", envelope.volume);
    print("  {}{}, genus {:g}\n", counted(envelope.components, "component"),
          envelope.cavities > 0 ? ", " + counted(envelope.cavities, "cavity", "cavities") : "",
          envelope.genus);
    if (how.simplify) {
      print("  simplified to {}; asked for at most {}\n",
            counted(envelope.mesh.triangles.size(), "triangle"), *how.simplify);
    }
    const char* chosen = how.voxelSize ? "" : " (by the size of the solid)";
    if (how.contains() && envelope.voxelSize > 0) {
      const auto by = one.outsideBy();
      print(
          "  voxel size {:g}{}; contains {}the {} for certain, and {} farther than {:.3g} "
          "from it\n",
          envelope.voxelSize, chosen,
          how.inflate ? fmt::format("what is within {:g} of ", *how.inflate) : "",
          by ? "motion" : "mesh", how.simplify ? "no point of the surface" : "nothing",
          by.value_or(envelope.errorBound));
    } else if (envelope.voxelSize > 0) {
      print("  voxel size {:g}{}; right farther than {:.3g} from the boundary\n",
            envelope.voxelSize, chosen, envelope.errorBound);
    } else if (how.exact) {
      print(
          "  exact, but for rounding and what touches: right farther than {:.3g} from the "
          "boundary\n",
          envelope.errorBound);
    }
    if (!one.chordBound) {
      print("  how far the mesh is from the motion between its layers is not known\n");
    } else if (*one.chordBound > 0) {
      print("  the mesh is within {:.4g} of the motion\n", *one.chordBound);
    }
    print("  volume of all visits {:.12g}, hypervolume {:.12g}\n", one.silhouette.visitsVolume,
          one.silhouette.hypervolume);
  }
}

/// The page: the envelope, and the solids at some times.
Result<void> writePage(const std::string& path, const EnvelopeReport& report) {
  const Input& input = report.passages.input;
  const ProgressBar bar("drawing");
  CaptionedSolids solids = {{"envelope", {}}};
  for (const Passage& one : report.passages.all) append(solids[0].second, one.envelope.mesh);
  constexpr std::uint64_t kTimes = 3;
  for (const double time : model::evenTimes(report.passages.span, kTimes)) {
    model::TriangleMesh solid;
    for (const model::Body& body : input.bodies) {
      if (!model::timeWithin(*body.source, time)) continue;
      const auto slice = slice::slice(*body.source, slice::Hyperplane::atTime(time));
      if (!slice) return slice.error();
      append(solid, slice->mesh);
    }
    solids.emplace_back(fmt::format("t = {:.6g}", time), std::move(solid));
  }
  Table numbers = {{}};
  const auto members = Members::valueOf(report);
  for (const auto& [name, value] : members.items()) {
    if (name == "bodies") break;
    std::string title = name;
    std::ranges::replace(title, '_', ' ');
    numbers.push_back({title, value.dump()});
  }
  return formats::writeOutputFile(
      path, envelopePage("Envelope of " + input.name, solids, input.metadata.up == "z", numbers));
}

void printFields(const EnvelopeReport& report) {
  for (const auto& [name, file, bytes] : report.fields) {
    print("  {}: {}, {}\n", file, name, sizeText(bytes));
  }
  print("  {:.2f} s, peak memory {}\n", report.seconds, sizeText(peakBytes()));
}

void printPart(const EnvelopeReport& report) {
  const auto& [number, count] = *report.options.part;
  print("part {} of {} of the fields; voxel size {:g}{}\n", number, count, report.fieldVoxelSize,
        report.options.voxelSize ? "" : " (by the size of the solid)");
}

void printReport(const EnvelopeReport& made, const EnvelopeArguments& options) {
  if (options.json) {
    const auto identity = [&] { return identityOf(made.passages.input); };
    tools::printText(options.part.inReport(Members::valueOf(made), identity) + "\n");
    return;
  }
  made.options.part ? printPart(made) : printPassages(made);
  printFields(made);
}

/// The losses, with the options that may help.
std::vector<std::string> lossesOf(EnvelopeReport made) {
  for (Passage& one : made.passages.all) {
    std::vector<std::string>& own = one.envelope.losses;
    const std::string ways = otherWays(made.options, one);
    if (!own.empty() && !ways.empty()) own.back() += fmt::format("; {} finds what is thin", ways);
  }
  return made.losses();
}

void warnOfHypervolume(const Passages& passages) {
  for (const Passage& one : passages.all) {
    if (const auto doubt = doubtOfHypervolume(one, passages.span)) {
      printNotices({*doubt + "; t4d validate --deep may say why"});
    }
  }
}

int run(EnvelopeArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  if (auto good = checkOutputs(outputsOf(options), {&options.input, 1}); !good) {
    return report(good.error());
  }
  const platform::Stopwatch stopwatch;
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  EnvelopeOptions& how = options.envelope;
  how.window = options.window;
  how.generator = versionText();
  how.memory = 1e9 * options.memory;
  if (options.part.isAsked()) how.part = options.part.chosen();
  ConsoleObserver observer;
  auto passages = passagesOf(*input, how, observer);
  if (!passages) return report(passages.error());
  if (how.part) {
    const auto most = mostFieldParts(*passages, how);
    if (!most) return report(most.error());
    if (const auto done = options.part.settle(*most, "blocks of 8 planes along x")) return *done;
  } else if (auto good = checkBodyFiles(options, *passages); !good) {
    return report(good.error());
  }
  warnOfHypervolume(*passages);
  auto made = envelope(std::move(*passages), how, observer);
  if (!made) return report(made.error());
  if (!options.html.empty()) {
    if (auto written = writePage(options.html, *made); !written) {
      return report(inInput(written.error(), *input));
    }
  }
  made->seconds = stopwatch.seconds();
  printReport(*made, options);
  return reportLosses(lossesOf(std::move(*made)), how.center);
}

}  // namespace

void addEnvelope(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "envelope", "Compute the solid that a motion passes through (swept volume)");
  auto options = std::make_shared<EnvelopeArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  command
      ->add_option("-o,--output", options->envelope.output,
                   fmt::format("Output file: {} (default: none, only measure); with --each, one "
                               "per body if {{body}} is in its name",
                               formats::writableTriangleMeshExtensions()))
      ->check(someName())
      ->check(writableTriangleMesh());
  command
      ->add_option("--voxel-size", options->envelope.voxelSize,
                   "Lattice spacing, in length units (default: from the size of the solid)")
      ->check(numberAboveZero());
  command
      ->add_flag("--exact", options->envelope.exact,
                 "Cut the silhouette's triangles exactly instead; suits a few hundred")
      ->excludes("--voxel-size");
  command
      ->add_option("--inflate", options->envelope.inflate,
                   "As --outside, with everything within this distance of the motion")
      ->check(numberFromZero());
  command
      ->add_option("--simplify", options->envelope.simplify,
                   "As --outside, with at most this many triangles, for collision checks")
      ->check(CLI::Range(std::uint64_t{4}, std::uint64_t{1'000'000'000}));
  command->add_flag("--outside", options->envelope.outside,
                    "Make a slightly larger envelope that contains the whole motion");
  for (const FieldOption& field : kFieldOptions) {
    command
        ->add_option(field.option, options->envelope.fields.*field.file,
                     fmt::format("Output file (.vdb): {}", field.help))
        ->type_name("FILE")
        ->check(outputByExtension({".vdb"}));
  }
  options->window.addTo(*command);
  options->only.addTo(*command);
  command->add_flag("--each", options->envelope.each,
                    "Make one envelope per body (default: one of all bodies)");
  command->add_option("--max-memory", options->memory, "Maximum memory, in GB")
      ->check(numberAboveZero())
      ->capture_default_str();
  command
      ->add_option("--html", options->html,
                   "Write a page with pictures of the envelope and of the solid")
      ->type_name("FILE")
      ->check(htmlFile());
  addCenterOption(*command, options->envelope.center);
  options->part.addTo(
      *command,
      "Make only part K of N of the fields (--visits and so on), divided along x; `t4d join` joins "
      "the files");
  addJsonOption<EnvelopeReport>(*command, options->json, "The solid that a motion passes through.");
  command->footer("Example:\n  t4d envelope bolt.t4d -o clearance.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
