#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/convert/frame_files.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/join.h"
#include "t4d/formats/t4d/shared_join.h"
#include "t4d/verbs/join_reports.h"
#include "t4d/voxel4d/point_field_parts.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/t4d_output.h"

namespace t4d::tools {
namespace {

struct JoinArguments {
  std::vector<std::string> parts;
  std::string output;
  bool manifest = false;
  bool plan = false;
  bool finish = false;
  PartOption part;
  bool json = false;
};

bool isJson(const std::string& path) { return formats::lowerCaseExtension(path) == ".json"; }

bool isVdb(const std::string& path) { return formats::lowerCaseExtension(path) == ".vdb"; }

/// The manifests of parts of a series of frames have the name of the whole one in them.
bool isFrameManifest(const std::string& path) {
  return std::filesystem::path(path).filename().string().find("manifest.part-") !=
         std::string::npos;
}

int joinFrameManifests(const JoinArguments& options) {
  if (options.output.empty()) return wrongUsage("-o: name the manifest of all frames");
  const auto frames =
      convert::joinManifests({options.parts.begin(), options.parts.end()}, options.output);
  if (!frames) return report(frames.error());
  if (options.json) {
    printJson({{"parts", options.parts.size()}, {"frames", *frames}});
  } else {
    print("{}: {} of {}\n", options.output, counted(*frames, "frame"),
          counted(options.parts.size(), "part"));
  }
  return kDone;
}

int joinReports(const JoinArguments& options) {
  const auto joined = verbs::joinReports({options.parts.begin(), options.parts.end()});
  if (!joined) return report(joined.error());
  const std::string text = joined->json + "\n";
  if (options.output.empty() || options.output == "-") {
    tools::printText(text);
  } else {
    auto file = formats::OutputFile::create(options.output);
    if (!file) return report(file.error());
    const auto written =
        file->write(text.data(), text.size()).and_then([&] { return file->commit(); });
    if (!written) return report(written.error());
    print("{}: report of {} on {}\n", options.output, joined->verb,
          counted(options.parts.size(), "part"));
  }
  return joined->valid ? kDone : kInvalid;
}

int joinFields(const JoinArguments& options) {
  if (!std::ranges::all_of(options.parts, isVdb)) {
    return wrongUsage("parts of a field (.vdb) are not joined with other files");
  }
  if (!isVdb(options.output)) return wrongUsage("-o: name the field (.vdb) of all parts");
  const std::vector<std::filesystem::path> parts(options.parts.begin(), options.parts.end());
  const auto joined = voxel4d::joinPointFields(parts, options.output);
  if (!joined) return report(joined.error());
  if (options.json) {
    printJson({{"parts", parts.size()},
               {"field", joined->name},
               {"active", joined->activePoints},
               {"bytes", joined->bytes}});
  } else {
    print("{}: {} of {} at {}, {}\n", options.output, joined->name, counted(parts.size(), "part"),
          counted(joined->activePoints, "point"), sizeText(joined->bytes));
  }
  return kDone;
}

/// The error message if the name of the output is not that of what is made of meshes.
std::optional<std::string> misuseOfName(const JoinArguments& options) {
  if (options.output.empty()) return "--output is required";
  const bool named = formats::lowerCaseExtension(options.output) == ".t4dm";
  if (options.manifest && !named) {
    return fmt::format("a manifest has a name that ends in .t4dm, not {}", options.output);
  }
  if (named && !options.manifest) {
    return fmt::format("{}: to write a manifest of the parts, add --manifest", options.output);
  }
  std::string name = options.output;
  const std::string wrong = named ? "" : noOtherFormat()(name);
  return wrong.empty() ? std::nullopt : std::optional("--output: " + wrong);
}

void printSums(const formats::JoinReport& joined, const JoinArguments& options,
               const std::string& sentence) {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  for (const formats::BodySummary& body : joined.bodies) {
    slabs += body.slabs;
    vertices += body.vertices;
    tetrahedra += body.tetrahedra;
  }
  if (options.json) {
    printJson({{"parts", joined.parts},
               {"slabs", slabs},
               {"vertices", vertices},
               {"tetrahedra", tetrahedra},
               {"bytes", joined.bytes}});
    return;
  }
  print("{}: {} of {}, {}\n", options.output, counted(slabs, "slab"), sentence,
        sizeText(joined.bytes));
  print("  {}, {}\n", counted(vertices, "vertex", "vertices"),
        counted(tetrahedra, "tetrahedron", "tetrahedra"));
}

int planJoin(const JoinArguments& options) {
  Result<formats::JoinReport> planned;
  {
    ProgressBar bar("planning");
    planned = formats::planJoin({options.parts.begin(), options.parts.end()}, options.output,
                                bar.callback());
  }
  if (!planned) return report(planned.error());
  printSums(*planned, options, counted(planned->parts, "file") + " planned");
  if (!options.json) {
    print("  next: join with the same -o and --part K/{}, then with --finish\n", planned->parts);
  }
  return reportLosses(planned->losses);
}

int copyParts(const JoinArguments& options) {
  const auto most = formats::plannedParts(options.output);
  if (!most) return report(most.error());
  if (const auto settled = options.part.settle(*most, "files to join")) return *settled;
  Result<formats::SharedCopy> copied;
  {
    ProgressBar bar("copying");
    copied = formats::copyPlannedParts(options.output, options.part.chosen(), bar.callback());
  }
  if (!copied) return report(copied.error());
  if (options.json) {
    printJson({{"parts", *most}, {"copied", copied->parts}, {"bytes", copied->bytes}});
  } else {
    print("{}: {} copied, {}\n", options.output, counted(copied->parts, "file"),
          sizeText(copied->bytes));
  }
  return kDone;
}

int finishJoin(const JoinArguments& options) {
  const auto joined = formats::finishJoin(options.output);
  if (!joined) return report(joined.error());
  printSums(*joined, options, counted(joined->parts, "file"));
  return kDone;
}

/// The error message if options exclude each other.
std::optional<std::string> misuseOfSteps(const JoinArguments& options) {
  const bool copies = options.part.isAsked();
  if (options.plan + options.finish + copies + options.manifest > 1) {
    return "--manifest, --plan, --part and --finish exclude each other";
  }
  if ((options.finish || copies) && !options.parts.empty()) {
    return "--part, --most-parts and --finish take the files that were planned; name none";
  }
  if (options.parts.empty() && !options.finish && !copies) return "name the files to join";
  if (options.output == "-" && (options.plan || options.finish || copies)) {
    return "-o: name a file; many processes cannot write to the standard output";
  }
  return std::nullopt;
}

int run(const JoinArguments& options) {
  if (const auto misuse = misuseOfSteps(options)) return wrongUsage(*misuse);
  if (const auto misuse = misuseOfOutput(options.output, options.parts)) return wrongUsage(*misuse);
  const bool isMesh =
      !std::ranges::any_of(options.parts, isVdb) && !std::ranges::any_of(options.parts, isJson);
  if (!isMesh && (options.manifest || options.plan)) {
    return wrongUsage("--manifest and --plan are for meshes (.t4d)");
  }
  if (std::ranges::any_of(options.parts, isVdb)) return joinFields(options);
  if (std::ranges::any_of(options.parts, isJson)) {
    if (!std::ranges::all_of(options.parts, isJson)) {
      return wrongUsage("reports (.json) and meshes (.t4d) are not joined with each other");
    }
    return std::ranges::any_of(options.parts, isFrameManifest) ? joinFrameManifests(options)
                                                               : joinReports(options);
  }
  if (const auto misuse = misuseOfName(options)) return wrongUsage(*misuse);
  if (options.plan) return planJoin(options);
  if (options.part.isAsked()) return copyParts(options);
  if (options.finish) return finishJoin(options);
  Result<formats::JoinReport> joined;
  {
    const std::vector<std::filesystem::path> parts(options.parts.begin(), options.parts.end());
    ProgressBar bar(options.manifest ? "checking" : "joining");
    joined = options.manifest ? formats::writeManifest(parts, options.output, bar.callback())
                              : formats::joinT4d(parts, options.output, bar.callback());
  }
  if (!joined) return report(joined.error());
  printSums(*joined, options, counted(joined->parts, options.manifest ? "part" : "file"));
  return reportLosses(joined->losses);
}

}  // namespace

void addJoin(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "join", "Join consecutive .t4d files without decoding them, or reports or fields of parts");
  command->alias("concat");
  auto options = std::make_shared<JoinArguments>();
  command->add_option(
      "PART", options->parts,
      "Input files: .t4d and .t4dm (files or URLs), in the order of their times, or reports "
      "(.json) or fields (.vdb) of parts");
  command
      ->add_option("-o,--output", options->output,
                   "Output file: .t4d, .t4dm with --manifest, .vdb of fields; of reports .json "
                   "(default: standard output)")
      ->check(someName());
  command->add_flag("--manifest", options->manifest,
                    "Write a manifest (.t4dm) that names the parts, instead of copying them");
  command->add_flag("--plan", options->plan,
                    "Plan a join by several processes, which --part and --finish complete");
  options->part.addTo(
      *command,
      "Copy share K of N of the planned files to their places (after --plan, with the same "
      "-o; name no files)");
  command->add_flag("--finish", options->finish,
                    "End a planned join: give the file its name when all files are copied");
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example, with two processes at work:\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 1/2 -o first.t4d &\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 2/2 -o second.t4d; wait\n"
      "  t4d join first.t4d second.t4d -o bolt.t4d\n"
      "or, without copying:\n"
      "  t4d join first.t4d second.t4d --manifest -o bolt.t4dm\n"
      "by several processes at a time:\n"
      "  t4d join first.t4d second.t4d -o bolt.t4d --plan\n"
      "  t4d join -o bolt.t4d --part 1/2 & t4d join -o bolt.t4d --part 2/2; wait\n"
      "  t4d join -o bolt.t4d --finish\n"
      "fields:\n"
      "  t4d join dwell-1.vdb dwell-2.vdb -o dwell.vdb\n"
      "and reports:\n"
      "  t4d validate bolt.t4d --part 1/2 --json > p1.json &\n"
      "  t4d validate bolt.t4d --part 2/2 --json > p2.json; wait; t4d join p1.json p2.json");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
