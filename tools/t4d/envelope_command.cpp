#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "platform/stopwatch.h"
#include "t4d/slice.h"
#include "tools/report/solid_picture.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/envelope_page.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/time_window.h"
#include "tools/t4d/version.h"
#include "tools/verbs/body_files.h"
#include "tools/verbs/envelope.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;
using verbs::Passage;

struct EnvelopeArguments {
  std::string input;
  InputOptions only;
  TimeWindow window;
  verbs::EnvelopeOptions envelope;
  PartOption part;
  std::string html;
  double memory = 4;  // GB
  bool json = false;
};

struct FieldOption {
  const char* option;
  std::string verbs::VisitFieldFiles::*file;
  const char* help;
};
constexpr std::array<FieldOption, 4> kFieldOptions = {{
    {"--visits", &verbs::VisitFieldFiles::visits, "number of visits of each point, as int32"},
    {"--dwell", &verbs::VisitFieldFiles::dwell, "how long each point is covered"},
    {"--first", &verbs::VisitFieldFiles::first, "when each point is first covered"},
    {"--last", &verbs::VisitFieldFiles::last, "when each point is last covered"},
}};

std::vector<std::string> outputsOf(const EnvelopeArguments& options) {
  std::vector<std::string> outputs = {options.html};
  if (!verbs::isPerBody(options.envelope.output)) outputs.push_back(options.envelope.output);
  for (const FieldOption& field : kFieldOptions) {
    outputs.push_back(options.envelope.fields.*field.file);
  }
  std::erase(outputs, "");
  return outputs;
}

/// Why a part of the fields cannot be made with the options.
std::optional<std::string> misuseOfPart(const EnvelopeArguments& options) {
  if (!options.part.isAsked()) return std::nullopt;
  const verbs::EnvelopeOptions& how = options.envelope;
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
  const verbs::EnvelopeOptions& how = options.envelope;
  if (verbs::isPerBody(how.output) && !how.each) {
    return "-o: a file per body, by {body}, needs --each";
  }
  if (auto misuse = verbs::misuseOfPerBody(how.output)) return misuse;
  if (how.each && how.fields.any()) {
    return "--each: fields are of all bodies together; choose one by --body";
  }
  if (how.contains() && how.exact) {
    return "--outside, --inflate or --simplify: an envelope that contains the motion for certain "
           "is "
           "made on a lattice, not with --exact";
  }
  if (auto misuse = misuseOfPart(options)) return misuse;
  return options.window.misuse();
}

/// Checks the files of the bodies, whose names are not known before.
Result<void> checkBodyFiles(const EnvelopeArguments& options, const verbs::Passages& passages) {
  if (!verbs::isPerBody(options.envelope.output)) return {};
  std::vector<std::string> names;
  for (const Passage& one : passages.all) names.push_back(one.name);
  const auto files = verbs::bodyFiles(options.envelope.output, names);
  if (!files) return files.error();
  std::vector<std::string> outputs = {options.html};
  for (const auto& file : *files) outputs.push_back(file.string());
  return checkOutputs(outputs);
}

/// Options that find a thin solid, or take less time.
std::string otherWays(const verbs::EnvelopeOptions& how, const Passage& one) {
  if (how.contains()) return {};
  return !how.exact && one.hasFewTriangles() ? "--exact or --outside" : "--outside";
}

void printPassages(const verbs::EnvelopeReport& report) {
  const verbs::EnvelopeOptions& how = report.options;
  const std::vector<Passage>& all = report.passages.all;
  for (const Passage& one : all) {
    const edit::Envelope& envelope = one.envelope;
    const bool several = all.size() > 1;
    const bool perBody = verbs::isPerBody(how.output);
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
Result<void> writePage(const std::string& path, const verbs::EnvelopeReport& report) {
  const verbs::Input& input = report.passages.input;
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
  const auto members = verbs::Members::valueOf(report);
  for (const auto& [name, value] : members.items()) {
    if (name == "bodies") break;
    std::string title = name;
    std::ranges::replace(title, '_', ' ');
    numbers.push_back({title, value.dump()});
  }
  return formats::writeOutputFile(
      path, envelopePage("Envelope of " + input.name, solids, input.metadata.up == "z", numbers));
}

void printFields(const verbs::EnvelopeReport& report) {
  for (const auto& [name, file, bytes] : report.fields) {
    print("  {}: {}, {}\n", file, name, sizeText(bytes));
  }
  print("  {:.2f} s, peak memory {}\n", report.seconds, sizeText(peakBytes()));
}

void printPart(const verbs::EnvelopeReport& report) {
  const auto& [number, count] = *report.options.part;
  print("part {} of {} of the fields; voxel size {:g}{}\n", number, count, report.fieldVoxelSize,
        report.options.voxelSize ? "" : " (by the size of the solid)");
}

void printReport(const verbs::EnvelopeReport& made, const EnvelopeArguments& options) {
  if (options.json) {
    const auto identity = [&] { return identityOf(made.passages.input); };
    tools::printText(options.part.inReport(verbs::Members::valueOf(made), identity) + "\n");
    return;
  }
  made.options.part ? printPart(made) : printPassages(made);
  printFields(made);
}

/// The losses, with the options that may help.
std::vector<std::string> lossesOf(verbs::EnvelopeReport made) {
  for (Passage& one : made.passages.all) {
    std::vector<std::string>& own = one.envelope.losses;
    const std::string ways = otherWays(made.options, one);
    if (!own.empty() && !ways.empty()) own.back() += fmt::format("; {} finds what is thin", ways);
  }
  return made.losses();
}

void warnOfHypervolume(const verbs::Passages& passages) {
  for (const Passage& one : passages.all) {
    if (const auto doubt = verbs::doubtOfHypervolume(one, passages.span)) {
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
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  verbs::EnvelopeOptions& how = options.envelope;
  how.window = options.window;
  how.generator = versionText();
  how.memory = 1e9 * options.memory;
  if (options.part.isAsked()) how.part = options.part.chosen();
  ConsoleObserver observer;
  auto passages = verbs::passagesOf(*input, how, observer);
  if (!passages) return report(passages.error());
  if (how.part) {
    const auto most = verbs::mostFieldParts(*passages, how);
    if (!most) return report(most.error());
    if (const auto done = options.part.settle(*most, "blocks of 8 planes along x")) return *done;
  } else if (auto good = checkBodyFiles(options, *passages); !good) {
    return report(good.error());
  }
  warnOfHypervolume(*passages);
  auto made = verbs::envelope(std::move(*passages), how, observer);
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
  addJsonOption<verbs::EnvelopeReport>(*command, options->json,
                                       "The solid that a motion passes through.");
  command->footer("Example:\n  t4d envelope bolt.t4d -o clearance.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
