#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/clip_time.h"
#include "t4d/edit/collision_mesh.h"
#include "t4d/edit/envelope.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/formats/triangle/triangle_mesh_writer.h"
#include "t4d/measure/chord_bound.h"
#include "t4d/slice/slice.h"
#include "t4d/verbs/json_text.h"
#include "t4d/verbs/origin.h"
#include "t4d/voxel4d/point_field.h"
#include "tools/program/body_files.h"
#include "tools/program/centering.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/envelope_fields.h"
#include "tools/program/envelope_page.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/progress_bar.h"
#include "tools/program/time_window.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

using edit::Envelope;
using measure::Silhouette;
using nlohmann::ordered_json;

struct EnvelopeArguments {
  std::string input;
  InputOptions only;
  TimeWindow window;
  bool each = false;
  std::string output;
  std::optional<double> voxelSize;
  double maxMemoryGiB = 4;
  bool exact = false;
  bool outside = false;
  std::optional<double> inflate;          // with it, outside is set
  std::optional<std::uint64_t> simplify;  // with it, outside is set
  EnvelopeFields fields;
  PartOption part;
  std::string html;
  bool center = false;
  bool json = false;
};

/// The most triangles of a silhouette for which --exact is named: a thousand may take minutes.
constexpr std::size_t kFewTriangles = 500;

/// What one or several bodies pass through.
struct Passed {
  std::string name;
  Silhouette silhouette;
  std::optional<double> chordBound = {};  // nothing if that is not known of a body
  Envelope envelope = {};
  std::string file = {};  // "" if none is written
};

/// Puts the part of a body within the span into a sink.
Result<void> putPart(const model::Body& body, const TimeWindow& window, const model::TimeSpan& span,
                     model::Sink& sink, const model::Progress& progress) {
  if (window.isWhole()) return model::pump(*body.source, sink, progress);
  const auto clip = edit::clipTime(*body.source, span, sink, progress);
  if (!clip) return clip.error();
  return {};
}

Result<std::vector<Passed>> silhouettesOf(const EnvelopeArguments& options,
                                          const verbs::Input& input, const model::TimeSpan& span) {
  // Bounds of chords are read off the same slabs again; those are of the surface.
  const bool withChords = !options.part.isAsked();
  ProgressBar bar("finding the silhouette", (withChords ? 2 : 1) * verbs::slabCountOf(input.bodies),
                  "slabs");
  std::vector<Passed> all;
  for (const model::Body& body : input.bodies) {
    const auto inBody = [&](Error error) {
      error.where = fmt::format("{}: body '{}'{}{}", input.name, body.name,
                                error.where.empty() ? "" : ", ", error.where);
      return error;
    };
    measure::SilhouetteBuilder builder;
    if (auto put = putPart(body, options.window, span, builder, bar.part(body.source->slabCount()));
        !put) {
      return inBody(put.error());
    }
    auto silhouette = builder.finish();
    if (!silhouette) return inBody(silhouette.error());
    std::optional<double> bound;
    if (withChords) {
      const auto chords = measure::chordBound(*body.source, span, motionOf(input, body.name),
                                              bar.part(body.source->slabCount()));
      if (!chords) return inBody(chords.error());
      if (*chords) bound = (*chords)->bound;
    }
    if (options.each || all.empty()) {
      all.push_back({body.name, std::move(*silhouette), bound});
    } else {
      edit::add(all[0].silhouette, *silhouette);
      all[0].chordBound =
          all[0].chordBound && bound ? std::max(all[0].chordBound, bound) : std::nullopt;
      all[0].name = "envelope";
    }
  }
  return all;
}

/// Chooses the file of each body, if each has its own.
Result<void> chooseFiles(const EnvelopeArguments& options, std::vector<Passed>& all) {
  if (!isPerBody(options.output)) {
    for (Passed& one : all) one.file = options.output;
    return {};
  }
  std::vector<std::string> names;
  for (const Passed& one : all) names.push_back(one.name);
  const auto files = bodyFiles(options.output, names);
  if (!files) return files.error();
  std::vector<std::string> outputs = {options.html};
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].file = (*files)[i].string();
    outputs.push_back(all[i].file);
  }
  if (auto misuse = misuseOfOutputs(outputs)) return fail(ErrorCode::Failed, *misuse);
  return checkWritable(outputs);
}

bool isSinglePrecision(const std::string& output) {
  const auto* format = formats::triangleMeshFormat(output);
  return format != nullptr && (format->placed || format->extension == ".stl");
}

model::Bounds3 boundsOf(const std::vector<Passed>& all) {
  model::Bounds3 bounds;
  for (const Passed& one : all) bounds.add(model::boundsOf(one.silhouette.surface));
  return bounds;
}

Result<std::vector<std::string>> write(const EnvelopeArguments& options,
                                       const std::vector<Passed>& all, const model::Point3& center,
                                       const formats::Metadata& metadata) {
  std::vector<formats::NamedMesh> meshes;
  for (const Passed& one : all) meshes.push_back({one.name, one.envelope.mesh});
  formats::MeshWriteOptions how;
  how.origin = verbs::originOf(metadata);
  how.center = center;
  if (formats::triangleMeshFormat(options.output)->placed) {
    std::vector<std::string> notices;
    how.placement = verbs::placementOf(metadata, notices);
    printNotices(notices);
  }
  const ProgressBar bar("writing " + options.output);
  if (!isPerBody(options.output)) return formats::writeTriangleMeshes(options.output, meshes, how);
  std::vector<std::filesystem::path> files;
  for (const Passed& one : all) files.emplace_back(one.file);
  return formats::writeEachTriangleMesh(files, meshes, how);
}

/// What is the same in all parts of the fields of a run, by name.
std::map<std::string, std::string> runOf(const verbs::Input& input, const model::TimeSpan& span) {
  std::map<std::string, std::string> run = {{"version of t4d", std::string(versionText())},
                                            {"first time", fmt::format("{}", span.begin)},
                                            {"last time", fmt::format("{}", span.end)}};
  const ordered_json identity = identityOf(input);
  for (const auto& [name, number] : identity.items()) run["input's " + name] = number.dump();
  auto names = ordered_json::array();
  for (const model::Body& body : input.bodies) names.push_back(body.name);
  run["list of bodies"] = names.dump();
  return run;
}

/// Writes the fields that are asked for, or the part of them.
Result<std::vector<WrittenField>> writeFields(const EnvelopeArguments& options,
                                              const verbs::Input& input,
                                              const model::TimeSpan& span,
                                              measure::SpaceLattice lattice) {
  FieldWork work = {.lattice = std::move(lattice), .part = options.part.chosen()};
  if (options.part.isGiven()) work.run = runOf(input, span);
  work.put = [&](model::Sink& fields) -> Result<void> {
    ProgressBar bar("counting visits", verbs::slabCountOf(input.bodies), "slabs");
    for (const model::Body& body : input.bodies) {
      auto put = putPart(body, options.window, span, fields, bar.part(body.source->slabCount()));
      if (!put) return put;
    }
    return {};
  };
  return writeFields(options.fields, work);
}

std::vector<std::string> outputsOf(const EnvelopeArguments& options) {
  std::vector<std::string> outputs = {options.html};
  if (!isPerBody(options.output)) outputs.push_back(options.output);
  outputs.insert(outputs.end(), options.fields.files.begin(), options.fields.files.end());
  std::erase(outputs, "");
  return outputs;
}

/// Why a part of the fields cannot be made with the options.
std::optional<std::string> misuseOfPart(const EnvelopeArguments& options) {
  if (!options.part.isAsked()) return std::nullopt;
  if (!options.output.empty() || !options.html.empty() || options.each || options.exact ||
      options.outside || options.center) {
    return "--part divides the fields alone, without -o, --html, --each, --exact, --outside, "
           "--inflate, --simplify and --center: the surface is that of the whole motion";
  }
  if (options.part.isGiven() && !options.fields.any()) {
    return "--part divides the fields: give --visits, --dwell, --first or --last";
  }
  return std::nullopt;
}

/// Why the options cannot be.
std::optional<std::string> misuseOf(const EnvelopeArguments& options) {
  const std::vector<std::string> outputs = outputsOf(options);
  for (const std::string& output : outputs) {
    if (auto misuse = misuseOfOutput(output, {&options.input, 1})) return misuse;
  }
  if (auto misuse = misuseOfOutputs(outputs)) return misuse;
  if (isPerBody(options.output) && !options.each) {
    return "-o: a file per body, by {body}, needs --each";
  }
  if (auto misuse = misuseOfPerBody(options.output)) return misuse;
  if (options.each && options.fields.any()) {
    return "--each: fields are of all bodies together; choose one by --body";
  }
  if (options.outside && options.exact) {
    return "--outside, --inflate or --simplify: an envelope that contains the motion for certain "
           "is "
           "made on a lattice, not with --exact";
  }
  if (auto misuse = misuseOfPart(options)) return misuse;
  return options.window.misuse();
}

/// No place of an envelope made with --outside, and no point of the surface of one made with
/// --simplify, is farther than this from the motion; null where the motion is not known.
std::optional<double> outsideBy(const Passed& one) {
  if (!one.chordBound) return std::nullopt;
  return one.envelope.errorBound + *one.chordBound;
}

/// What else finds a thin solid, or takes less time.
std::string otherWays(const EnvelopeArguments& options, const Silhouette& silhouette) {
  const bool few = silhouette.surface.triangles.size() <= kFewTriangles;
  std::string ways;
  if (!options.exact && !options.outside && few) ways = "--exact";
  if (!options.outside) ways += std::string(ways.empty() ? "" : " or ") + "--outside";
  return ways;
}

ordered_json jsonOf(const EnvelopeArguments& options, const std::vector<Passed>& all) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t silhouette = 0;
  std::uint64_t components = 0;
  std::uint64_t cavities = 0;
  double genus = 0;
  double volume = 0;
  double visitsVolume = 0;
  double hypervolume = 0;
  double byFlux = 0;
  double voxelSize = 0;
  double errorBound = 0;
  bool closed = true;
  std::optional<std::uint64_t> crossings = 0;
  std::optional<double> chords = 0;
  std::optional<double> outside = 0;
  for (const Passed& one : all) {
    const Silhouette& passed = one.silhouette;
    const Envelope& envelope = one.envelope;
    vertices += envelope.mesh.vertices.size();
    triangles += envelope.mesh.triangles.size();
    silhouette += passed.surface.triangles.size();
    closed = closed && model::isClosed(envelope.mesh);
    components += envelope.components;
    cavities += envelope.cavities;
    genus += envelope.genus;
    volume += envelope.volume;
    visitsVolume += passed.visitsVolume;
    hypervolume += passed.hypervolume;
    byFlux += passed.hypervolumeByFlux;
    voxelSize = std::max(voxelSize, envelope.voxelSize);
    errorBound = std::max(errorBound, envelope.errorBound);
    if (!envelope.selfIntersections) crossings.reset();
    chords = chords && one.chordBound ? std::max(chords, one.chordBound) : std::nullopt;
    outside = outside && outsideBy(one) ? std::max(outside, outsideBy(one)) : std::nullopt;
  }
  if (!options.outside) outside.reset();
  return {{"vertices", vertices},
          {"triangles", triangles},
          {"closed", closed},
          {"self_intersections", verbs::orNull(crossings)},
          {"components", components},
          {"cavities", cavities},
          {"genus", std::llround(genus)},
          {"volume", volume},
          {"visits_volume", visitsVolume},
          {"hypervolume", hypervolume},
          {"hypervolume_by_flux", byFlux},
          {"voxel_size", voxelSize > 0 ? ordered_json(voxelSize) : ordered_json()},
          {"error_bound", errorBound},
          {"chord_bound", verbs::orNull(chords)},
          {"outside", options.outside},
          {"inflate", verbs::orNull(options.inflate)},
          {"simplify", verbs::orNull(options.simplify)},
          {"outside_by", verbs::orNull(outside)},
          {"silhouette_triangles", silhouette}};
}

void printText(const EnvelopeArguments& options, const std::vector<Passed>& all) {
  for (const Passed& one : all) {
    const Envelope& envelope = one.envelope;
    const bool several = all.size() > 1;
    const bool perBody = isPerBody(options.output);
    print("{}{}{}, {}, {}; volume {:.12g}\n",
          one.file.empty() || (several && !perBody) ? "" : one.file + ": ",
          several && !perBody ? one.name + ": " : "",
          counted(envelope.mesh.vertices.size(), "vertex", "vertices"),
          counted(envelope.mesh.triangles.size(), "triangle"),
          model::isClosed(envelope.mesh) ? "closed" : "NOT CLOSED", envelope.volume);
    print("  {}{}, genus {:g}\n", counted(envelope.components, "component"),
          envelope.cavities > 0 ? ", " + counted(envelope.cavities, "cavity", "cavities") : "",
          envelope.genus);
    if (options.simplify) {
      print("  simplified to {}; asked for at most {}\n",
            counted(envelope.mesh.triangles.size(), "triangle"), *options.simplify);
    }
    const char* chosen = options.voxelSize ? "" : " (by the size of the solid)";
    if (options.outside && envelope.voxelSize > 0) {
      const auto by = outsideBy(one);
      print(
          "  voxel size {:g}{}; contains {}the {} for certain, and {} farther than {:.3g} "
          "from it\n",
          envelope.voxelSize, chosen,
          options.inflate ? fmt::format("what is within {:g} of ", *options.inflate) : "",
          by ? "motion" : "mesh", options.simplify ? "no point of the surface" : "nothing",
          by.value_or(envelope.errorBound));
    } else if (envelope.voxelSize > 0) {
      print("  voxel size {:g}{}; right farther than {:.3g} from the boundary\n",
            envelope.voxelSize, chosen, envelope.errorBound);
    } else if (options.exact) {
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
Result<void> writePage(const EnvelopeArguments& options, const std::vector<Passed>& all,
                       const verbs::Input& input, const model::TimeSpan& span) {
  const ProgressBar bar("drawing");
  auto file = formats::OutputFile::create(options.html);
  if (!file) return file.error();
  const formats::Metadata& metadata = input.metadata;
  EnvelopeReport page;
  page.title = "Envelope of " + input.name;
  page.zUp = metadata.up == "z";
  const auto append = [](model::TriangleMesh& to, const model::TriangleMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(to.vertices.size());
    to.vertices.insert(to.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& [a, b, c] : mesh.triangles) {
      to.triangles.push_back({a + first, b + first, c + first});
    }
  };
  model::TriangleMesh envelope;
  for (const Passed& one : all) append(envelope, one.envelope.mesh);
  page.solids.emplace_back("envelope", std::move(envelope));
  constexpr std::uint64_t kTimes = 3;
  for (const double time : model::evenTimes(span, kTimes)) {
    model::TriangleMesh solid;
    for (const model::Body& body : input.bodies) {
      if (!model::timeWithin(*body.source, time)) continue;
      const auto slice = slice::slice(*body.source, slice::Hyperplane::atTime(time));
      if (!slice) return slice.error();
      append(solid, slice->mesh);
    }
    page.solids.emplace_back(fmt::format("t = {:.6g}", time), std::move(solid));
  }
  const ordered_json numbers = jsonOf(options, all);
  for (const auto& [name, value] : numbers.items()) {
    std::string title = name;
    std::ranges::replace(title, '_', ' ');
    page.numbers.emplace_back(title, value.dump());
  }
  const std::string html = envelopePage(page);
  if (auto written = file->write(html.data(), html.size()); !written) return written;
  return file->commit();
}

void warnOfHypervolume(const Silhouette& silhouette, const model::TimeSpan& span) {
  const double error = std::abs(silhouette.hypervolume - silhouette.hypervolumeByFlux);
  // Coordinates are rounded, however small the solid is.
  constexpr double kMost = 1e-9;
  constexpr double kRounding = 1e-14;
  const double most = kMost * std::abs(silhouette.hypervolumeByFlux) +
                      kRounding * silhouette.visitsVolume * (span.end - span.begin);
  if (error <= most) return;
  printNotices(
      {fmt::format("the hypervolume is {} as the integral of dwell, but {} as a flux; "
                   "t4d validate --deep may say why",
                   silhouette.hypervolume, silhouette.hypervolumeByFlux)});
}

/// Adds to a report the fields and what every report has.
void addFields(ordered_json& report, const std::vector<WrittenField>& fields,
               const model::TimeSpan& span, double seconds) {
  report["fields"] = ordered_json::array();
  for (const auto& [name, file, bytes] : fields) {
    report["fields"].push_back({{"name", name}, {"file", file}, {"bytes", bytes}});
  }
  report["time_begin"] = span.begin;
  report["time_end"] = span.end;
  report["seconds"] = seconds;
  report["peak_bytes"] = peakBytes();
}

void printFields(const std::vector<WrittenField>& fields, double seconds) {
  for (const auto& [name, file, bytes] : fields) {
    print("  {}: {}, {}\n", file, name, sizeText(bytes));
  }
  print("  {:.2f} s, peak memory {}\n", seconds, sizeText(peakBytes()));
}

/// The report on a part of the fields: what is of the surface is null.
ordered_json jsonOfPart(const EnvelopeArguments& options, const Passed& passed, double voxelSize) {
  ordered_json value = jsonOf(options, {passed});
  for (const char* name : {"vertices", "triangles", "closed", "self_intersections", "components",
                           "cavities", "genus", "volume", "error_bound"}) {
    value[name] = nullptr;
  }
  value["voxel_size"] = voxelSize;
  value["bodies"] = ordered_json::array();
  return value;
}

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void printPart(const EnvelopeArguments& options, double voxelSize) {
  const model::Part part = options.part.chosen();
  print("part {} of {} of the fields; voxel size {:g}{}\n", part.number, part.count, voxelSize,
        options.voxelSize ? "" : " (by the size of the solid)");
}

/// The lattice of the fields, the same as that of the envelope.
Result<measure::SpaceLattice> fieldLattice(const EnvelopeArguments& options,
                                           const std::vector<Passed>& all,
                                           const edit::EnvelopeOptions& how) {
  const double voxelSize =
      options.voxelSize.value_or(edit::defaultVoxelSize(all.front().silhouette, how));
  return measure::SpaceLattice::about(boundsOf(all), voxelSize);
}

/// Makes a part of the fields, without the surface.
int makePart(const EnvelopeArguments& options, const verbs::Input& input,
             const model::TimeSpan& span, const std::vector<Passed>& all, Clock::time_point begin) {
  if (boundsOf(all).empty()) {
    return report(invalid("passes through nothing, so there are no fields", input.name));
  }
  auto lattice = fieldLattice(options, all, {.maxBytes = options.maxMemoryGiB * 0x1p30});
  if (!lattice) return report(inInput(lattice.error(), input));
  const std::uint64_t most = voxel4d::mostFieldParts(lattice->at[0].size());
  if (const auto done = options.part.settle(most, "blocks of 8 planes along x")) return *done;
  const auto fits = checkFieldMemory(*lattice, options.part.chosen(), options.maxMemoryGiB);
  if (!fits) return report(inInput(fits.error(), input));
  const double voxelSize = lattice->spacing;
  warnOfHypervolume(all.front().silhouette, span);
  const auto fields = writeFields(options, input, span, std::move(*lattice));
  if (!fields) return report(inInput(fields.error(), input));
  if (options.json) {
    ordered_json value = jsonOfPart(options, all.front(), voxelSize);
    addFields(value, *fields, span, secondsSince(begin));
    value["part"] = options.part.json(identityOf(input));
    printJson(value);
  } else {
    printPart(options, voxelSize);
    printFields(*fields, secondsSince(begin));
  }
  return kDone;
}

int run(const EnvelopeArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  if (auto writable = checkWritable(outputsOf(options)); !writable) {
    return report(writable.error());
  }
  const auto begin = Clock::now();
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto span = options.window.spanIn(*input);
  if (!span) return report(span.error());
  std::vector<std::string> notices;
  keepThoseWithin(*span, *input, notices);
  printNotices(notices);
  auto all = silhouettesOf(options, *input, *span);
  if (!all) return report(all.error());
  if (options.part.isAsked()) return makePart(options, *input, *span, *all, begin);
  if (auto chosen = chooseFiles(options, *all); !chosen) return report(chosen.error());

  const model::Bounds3 bounds = boundsOf(*all);
  const model::Point3 center =
      options.center ? verbs::roundCenterOf(bounds) : model::Point3(model::Point3::Zero());
  edit::EnvelopeOptions how{.voxelSize = options.voxelSize.value_or(0),
                            .maxBytes = options.maxMemoryGiB * 0x1p30,
                            .exact = options.exact};
  if (isSinglePrecision(options.output)) how.singlePrecisionAbout = center;
  std::vector<std::string> losses;
  std::optional<measure::SpaceLattice> lattice;
  if (options.fields.any() && !bounds.empty()) {
    auto made = fieldLattice(options, *all, how);
    if (!made) return report(inInput(made.error(), *input));
    const auto fits = checkFieldMemory(*made, {}, options.maxMemoryGiB);
    if (!fits) return report(inInput(fits.error(), *input));
    lattice = std::move(*made);
  }
  for (Passed& one : *all) {
    ProgressBar bar("making the envelope of " + one.name);
    if (options.outside) how.reach = one.chordBound.value_or(0) + options.inflate.value_or(0);
    auto envelope = options.simplify ? edit::collisionMeshOf(one.silhouette, how, *options.simplify,
                                                             bar.callback())
                                     : edit::envelopeOf(one.silhouette, how, bar.callback());
    if (!envelope) {
      Error error = envelope.error();
      const std::string ways = otherWays(options, one.silhouette);
      if (error.remedy == Remedy::VoxelSize && !ways.empty()) {
        error.message += fmt::format("; {} needs no voxels as small", ways);
      }
      if (options.exact && error.remedy == Remedy::None) {
        error.message += "; leave out --exact to find it on a lattice";
      } else if (how.singlePrecisionAbout && !options.center && error.remedy == Remedy::None) {
        error.message += "; or write them about the middle, with --center";
      }
      return report(inInput(std::move(error), *input));
    }
    one.envelope = std::move(*envelope);
    std::vector<std::string> own = one.envelope.losses;
    if (!own.empty() && !otherWays(options, one.silhouette).empty()) {
      own.back() += fmt::format("; {} finds what is thin", otherWays(options, one.silhouette));
    }
    if (options.outside && !one.chordBound) {
      own.emplace_back(
          "it is certain for the mesh as it is, straight between its layers: how far "
          "that is from the motion is not known");
    }
    for (const std::string& loss : own) {
      losses.push_back(all->size() > 1 ? fmt::format("{}: {}", one.name, loss) : loss);
    }
    warnOfHypervolume(one.silhouette, *span);
  }
  if (!options.output.empty()) {
    auto written = write(options, *all, center, input->metadata);
    if (!written) return report(written.error());
    losses.insert(losses.end(), written->begin(), written->end());
  }
  std::vector<WrittenField> fields;
  if (lattice) {
    auto written = writeFields(options, *input, *span, std::move(*lattice));
    if (!written) return report(inInput(written.error(), *input));
    fields = std::move(*written);
  }
  if (!options.html.empty()) {
    if (auto written = writePage(options, *all, *input, *span); !written) {
      return report(inInput(written.error(), *input));
    }
  }
  const double seconds = secondsSince(begin);
  if (options.json) {
    ordered_json value = jsonOf(options, *all);
    value["bodies"] = ordered_json::array();
    for (const Passed& one : *all) {
      ordered_json body = {{"name", one.name},
                           {"file", one.file.empty() ? ordered_json() : ordered_json(one.file)}};
      body.update(jsonOf(options, {one}));
      value["bodies"].push_back(std::move(body));
    }
    addFields(value, fields, *span, seconds);
    printJson(value);
  } else {
    printText(options, *all);
    printFields(fields, seconds);
  }
  return reportLosses(losses, options.center);
}

}  // namespace

void addEnvelope(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "envelope", "Compute the solid that a motion passes through (swept volume)");
  auto options = std::make_shared<EnvelopeArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  command
      ->add_option("-o,--output", options->output,
                   fmt::format("Output file: {} (default: none, only measure); with --each, one "
                               "per body if {{body}} is in its name",
                               formats::writableTriangleMeshExtensions()))
      ->check(someName())
      ->check(writableTriangleMesh());
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "Lattice spacing, in length units (default: from the size of the solid)")
      ->check(numberAboveZero());
  command
      ->add_flag("--exact", options->exact,
                 "Cut the silhouette's triangles exactly instead; suits a few hundred")
      ->excludes("--voxel-size");
  command
      ->add_option("--inflate", options->inflate,
                   "As --outside, with everything within this distance of the motion")
      ->check(numberFromZero());
  command
      ->add_option("--simplify", options->simplify,
                   "As --outside, with at most this many triangles, for collision checks")
      ->check(CLI::Range(std::uint64_t{4}, std::uint64_t{1'000'000'000}));
  command->add_flag("--outside", options->outside,
                    "Make a slightly larger envelope that contains the whole motion");
  options->fields.addTo(*command);
  options->window.addTo(*command);
  options->only.addTo(*command);
  command->add_flag("--each", options->each,
                    "Make one envelope per body (default: one of all bodies)");
  command->add_option("--max-memory", options->maxMemoryGiB, "Maximum memory, in GiB")
      ->check(numberAboveZero())
      ->capture_default_str();
  command
      ->add_option("--html", options->html,
                   "Write a page with pictures of the envelope and of the solid")
      ->type_name("FILE")
      ->check(someName());
  addCenterOption(*command, options->center);
  options->part.addTo(
      *command,
      "Make only part K of N of the fields (--visits and so on), divided along x; `t4d join` joins "
      "the files");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d envelope bolt.t4d -o clearance.glb");
  command->callback([=, &exitCode] {
    options->outside = options->outside || options->inflate || options->simplify;
    exitCode = run(*options);
  });
}

}  // namespace t4d::tools
