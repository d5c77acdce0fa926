#include "tools/t4d/join.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "convert/frame_files.h"
#include "formats/file_extension.h"
#include "formats/output_file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/join_reports.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/t4d_output.h"
#include "voxel4d/point_field_parts.h"

namespace t4d::tools {
namespace {

std::uint64_t sumOf(const formats::JoinReport& report,
                    std::uint64_t formats::BodySummary::*number) {
  std::uint64_t sum = 0;
  for (const formats::BodySummary& body : report.bodies) sum += body.*number;
  return sum;
}

}  // namespace

std::uint64_t JoinReport::slabs() const { return sumOf(*this, &formats::BodySummary::slabs); }
std::uint64_t JoinReport::vertices() const { return sumOf(*this, &formats::BodySummary::vertices); }
std::uint64_t JoinReport::tetrahedra() const {
  return sumOf(*this, &formats::BodySummary::tetrahedra);
}

Result<JoinReport> join(const std::vector<std::string>& parts, const std::string& output,
                        JoinInto into, Observer& observer) {
  const std::vector<std::filesystem::path> files(parts.begin(), parts.end());
  const bool named = into == JoinInto::Manifest;
  const auto stage = observer.stage(named ? "checking" : "joining");
  auto joined = named ? formats::writeManifest(files, output, stage->callback())
                      : formats::joinT4d(files, output, stage->callback());
  if (!joined) return joined.error();
  return JoinReport{std::move(*joined)};
}

Result<FieldJoin> joinFields(const std::vector<std::string>& parts, const std::string& output) {
  const std::vector<std::filesystem::path> files(parts.begin(), parts.end());
  const auto joined = voxel4d::joinPointFields(files, output);
  if (!joined) return joined.error();
  return FieldJoin{files.size(), joined->name, joined->activePoints, joined->bytes};
}

Result<FramesJoin> joinFrames(const std::vector<std::string>& parts, const std::string& output) {
  const auto frames = convert::joinManifests({parts.begin(), parts.end()}, output);
  if (!frames) return frames.error();
  return FramesJoin{parts.size(), *frames};
}

namespace {

constexpr const char* kParts = "Files that were joined.";

}  // namespace

void describe(Members& members, const JoinReport& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("slabs", report.slabs(), "Slabs of the file.");
  members("vertices", report.vertices(),
          "Vertices, those where two slabs or two parts meet counted once.");
  members("tetrahedra", report.tetrahedra(), "Cells of all slabs.");
  members("bytes", report.bytes, "Size of the file.");
}

void describe(Members& members, const FieldJoin& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("field", report.field, "Of fields: which one.")
      .oneOf({"visits", "dwell", "first", "last"});
  members("active", report.active, "Of fields: points that are visited.");
  members("bytes", report.bytes, "Size of the file.");
}

void describe(Members& members, const FramesJoin& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("frames", report.frames, "Of manifests: the frames of the series.").atLeast(1);
}

namespace {

struct JoinArguments {
  std::vector<std::string> parts;
  std::string output;
  bool manifest = false;
  bool json = false;
};

bool isJson(const std::string& path) { return formats::lowerCaseExtension(path) == ".json"; }

bool isVdb(const std::string& path) { return formats::lowerCaseExtension(path) == ".vdb"; }

/// The manifests of parts of a series of frames have the name of the whole one in them.
bool isFrameManifest(const std::string& path) {
  return std::filesystem::path(path).filename().string().find("manifest.part-") !=
         std::string::npos;
}

int runOnManifests(const JoinArguments& options) {
  const auto joined = joinFrames(options.parts, options.output);
  if (!joined) return report(joined.error());
  if (options.json) {
    printAsJson(*joined);
  } else {
    print("{}: {} of {}\n", options.output, counted(joined->frames, "frame"),
          counted(joined->parts, "part"));
  }
  return kDone;
}

int runOnReports(const JoinArguments& options) {
  const auto joined = joinReports({options.parts.begin(), options.parts.end()});
  if (!joined) return report(joined.error());
  const std::string text = joined->json + "\n";
  if (options.output.empty() || options.output == "-") {
    tools::printText(text);
  } else {
    if (auto written = formats::writeOutputFile(options.output, text); !written) {
      return report(written.error());
    }
    print("{}: report of {} on {}\n", options.output, joined->verb,
          counted(options.parts.size(), "part"));
  }
  return joined->valid ? kDone : kInvalid;
}

int runOnFields(const JoinArguments& options) {
  if (!std::ranges::all_of(options.parts, isVdb)) {
    return wrongUsage("parts of a field (.vdb) are not joined with other files");
  }
  const auto joined = joinFields(options.parts, options.output);
  if (!joined) return report(joined.error());
  if (options.json) {
    printAsJson(*joined);
  } else {
    print("{}: {} of {} at {}, {}\n", options.output, joined->field, counted(joined->parts, "part"),
          counted(joined->active, "point"), sizeText(joined->bytes));
  }
  return kDone;
}

/// The report is that of a file, of manifests or of fields.
nlohmann::ordered_json schemaOfJoin() {
  return {{"anyOf",
           {Members::schemaOf<JoinReport>(), Members::schemaOf<FramesJoin>(),
            Members::schemaOf<FieldJoin>()}}};
}

/// The extension of what the parts make.
std::string_view extensionOf(const JoinArguments& options) {
  if (std::ranges::any_of(options.parts, isVdb)) return ".vdb";
  if (std::ranges::any_of(options.parts, isJson)) return ".json";
  return options.manifest ? ".t4dm" : ".t4d";
}

/// The error message if the output is not named, or not as what is made of the parts.
std::optional<std::string> misuseOfName(const JoinArguments& options) {
  const std::string_view extension = extensionOf(options);
  if (options.output.empty()) {
    const bool isReport =
        extension == ".json" && !std::ranges::any_of(options.parts, isFrameManifest);
    return isReport ? std::nullopt : std::optional<std::string>("--output is required");
  }
  std::string name = options.output;
  const std::string wrong = outputFile({extension})(name);
  if (wrong.empty()) return std::nullopt;
  const bool isManifest = formats::lowerCaseExtension(name) == ".t4dm" && extension == ".t4d";
  return fmt::format("--output: {}{}", wrong,
                     isManifest ? "; add --manifest to write a manifest of the parts" : "");
}

void printSums(const JoinReport& joined, const JoinArguments& options,
               const std::string& sentence) {
  if (options.json) {
    printAsJson(joined);
    return;
  }
  print("{}: {} of {}, {}\n", options.output, counted(joined.slabs(), "slab"), sentence,
        sizeText(joined.bytes));
  print("  {}, {}\n", counted(joined.vertices(), "vertex", "vertices"),
        counted(joined.tetrahedra(), "tetrahedron", "tetrahedra"));
}

int joinMeshes(const JoinArguments& options) {
  const JoinInto into = options.manifest ? JoinInto::Manifest : JoinInto::File;
  ConsoleObserver observer;
  const auto joined = join(options.parts, options.output, into, observer);
  if (!joined) return report(joined.error());
  printSums(*joined, options, counted(joined->parts, options.manifest ? "part" : "file"));
  return reportLosses(joined->losses);
}

int run(const JoinArguments& options) {
  const bool isMesh =
      !std::ranges::any_of(options.parts, isVdb) && !std::ranges::any_of(options.parts, isJson);
  if (!isMesh && options.manifest) return wrongUsage("--manifest is for meshes (.t4d)");
  if (const auto misuse = misuseOfName(options)) return wrongUsage(*misuse);
  if (std::ranges::any_of(options.parts, isVdb)) return runOnFields(options);
  if (std::ranges::any_of(options.parts, isJson)) {
    if (!std::ranges::all_of(options.parts, isJson)) {
      return wrongUsage("reports (.json) and meshes (.t4d) are not joined with each other");
    }
    return std::ranges::any_of(options.parts, isFrameManifest) ? runOnManifests(options)
                                                               : runOnReports(options);
  }
  return joinMeshes(options);
}

}  // namespace

void addJoin(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "join", "Join consecutive .t4d files without decoding them, or reports or fields of parts");
  command->alias("concat");
  auto options = std::make_shared<JoinArguments>();
  command
      ->add_option("PART", options->parts,
                   "Input files: .t4d and .t4dm (files or URLs), in the order of their times, or "
                   "reports (.json) or fields (.vdb) of parts")
      ->required();
  command
      ->add_option("-o,--output", options->output,
                   "Output file: .t4d, .t4dm with --manifest, .vdb of fields; of reports .json "
                   "(default: standard output)")
      ->check(someName());
  command->add_flag("--manifest", options->manifest,
                    "Write a manifest (.t4dm) that names the parts, instead of copying them");
  addJsonOption(*command, options->json,
                "What was written, of all bodies together; or, of the manifests of frames, how "
                "many frames there are; or the field that parts of an envelope's fields make. "
                "Reports are joined to the report of their verb.",
                schemaOfJoin);
  command->footer(
      "Example, with two processes at work:\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 1/2 -o first.t4d &\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 2/2 -o second.t4d; wait\n"
      "  t4d join first.t4d second.t4d -o bolt.t4d\n"
      "or, without copying:\n"
      "  t4d join first.t4d second.t4d --manifest -o bolt.t4dm\n"
      "fields:\n"
      "  t4d join dwell-1.vdb dwell-2.vdb -o dwell.vdb\n"
      "and reports:\n"
      "  t4d validate bolt.t4d --part 1/2 --json > p1.json &\n"
      "  t4d validate bolt.t4d --part 2/2 --json > p2.json; wait; t4d join p1.json p2.json");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
