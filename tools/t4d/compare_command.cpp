#include <array>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/t4d/url.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "mesh4d/steps.h"
#include "platform/child_process.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/compare_page.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/motion_options.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/version.h"
#include "tools/t4d/voxel_series.h"
#include "tools/verbs/compare.h"
#include "tools/verbs/compare_methods.h"

namespace t4d::tools {
namespace {

constexpr std::uint64_t kMaxSlices = 100'000;
/// The number of pairs of solids that the page shows.
constexpr std::size_t kPictures = 3;

struct CompareArguments {
  std::string input;
  std::string other;  // "" for both backends on `input`
  std::string motion;
  MotionOptions table;
  std::vector<double> voxelSizes;
  voxel4d::FrameTimes frames;
  bool mask = false;
  std::optional<std::string> between;
  std::vector<std::string> caps;
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::string up = "y";
  std::optional<std::uint64_t> slices;
  std::string times;
  std::optional<std::uint64_t> maxCells;
  std::string keep;
  std::string html;
  std::string csv;
  bool eachBody = false;
  bool json = false;

  bool builds() const { return other.empty(); }
};

/// The error message if the options cannot be combined; nothing if they can.
std::optional<std::string> misuseOf(const CompareArguments& options) {
  if (options.builds()) {
    if (options.motion.empty() || options.voxelSizes.empty()) {
      return "one solid needs --motion and --voxel-size; or give two .t4d files";
    }
    return std::nullopt;
  }
  if (!options.motion.empty() || !options.voxelSizes.empty() || options.frames.count ||
      options.frames.step || options.mask || options.between || !options.caps.empty() ||
      options.rvMin || options.steps || !options.keep.empty() || !options.table.table.empty()) {
    return "--motion and its options, --voxel-size, --frames, --frame-time, --mask, --between, "
           "--caps, --rv-min, --steps and --keep are for one solid; two .t4d files are compared as "
           "they are";
  }
  return std::nullopt;
}

/// A path that is not mistaken for an option.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

/// Makes meshes by `t4d sweep`, each in a process of its own, whose memory can be told. A fork of
/// this process would not do: it lacks the threads that reading the solid may have started.
class SweepProcess {
 public:
  explicit SweepProcess(const CompareArguments& options) : options_(options) {}

  Result<verbs::MadeMesh> make(const verbs::SweepOptions& sweep) {
    const auto finished = platform::runSelf(wordsFor(sweep));
    if (!finished) return finished.error();
    if (finished->code != kDone && finished->code != kLoss) {
      const auto& voxels = std::get<verbs::MotionSweep>(sweep.what).voxels;
      failed_ = finished->code;
      return fail(ErrorCode::Failed,
                  fmt::format("the backend {} made no 4D mesh", voxels ? "voxel4d" : "mesh4d"));
    }
    const auto said = nlohmann::ordered_json::parse(finished->output, nullptr, false);
    if (!said.is_object() || !said.contains("seconds") || !said.contains("peak_bytes")) {
      return fail(ErrorCode::Failed, "`t4d sweep --json` did not say how long it took");
    }
    return verbs::MadeMesh{said["seconds"], said["peak_bytes"].get<std::uint64_t>()};
  }

  /// The exit code of the process that made no mesh, and has printed why.
  std::optional<int> failed() const { return failed_; }

 private:
  std::vector<std::string> wordsFor(const verbs::SweepOptions& sweep) const {
    const auto& voxels = std::get<verbs::MotionSweep>(sweep.what).voxels;
    std::vector<std::string> words = {
        "sweep",     asOperand(options_.input),     "--motion", asOperand(options_.motion),
        "--backend", voxels ? "voxel4d" : "mesh4d", "--up",     options_.up,
        "-o",        asOperand(sweep.output.path),  "--json"};
    const std::vector<std::string> table = options_.table.arguments();
    words.insert(words.end(), table.begin(), table.end());
    const auto add = [&](const char* option, const std::string& value) {
      words.emplace_back(option);
      words.push_back(value);
    };
    if (voxels) {
      add("--voxel-size", fmt::format("{}", voxels->voxelSize));
      if (voxels->times.count) add("--frames", fmt::format("{}", *voxels->times.count));
      if (voxels->times.step) add("--frame-time", fmt::format("{}", *voxels->times.step));
      if (options_.mask) words.emplace_back("--mask");
      if (options_.between) add("--between", *options_.between);
    } else {
      if (options_.rvMin) add("--rv-min", fmt::format("{}", *options_.rvMin));
      if (options_.steps) add("--steps", fmt::format("{}", *options_.steps));
    }
    for (const std::string& caps : options_.caps) {
      if (voxels.has_value() == isVoxelCaps(caps)) add("--caps", caps);
    }
    return words;
  }

  const CompareArguments& options_;
  std::optional<int> failed_;
};

/// A file's name without its folder.
std::string nameOf(const std::string& path) {
  return std::filesystem::path(formats::shownName(path)).filename().string();
}

/// The output files, opened before the work begins.
struct Outputs {
  std::optional<formats::OutputFile> html;
  std::optional<formats::OutputFile> csv;
};

Result<Outputs> createOutputs(const CompareArguments& options) {
  Outputs outputs;
  for (const auto& [path, file] :
       {std::pair{&options.html, &outputs.html}, std::pair{&options.csv, &outputs.csv}}) {
    if (path->empty()) continue;
    auto created = formats::OutputFile::create(*path);
    if (!created) return created.error();
    file->emplace(std::move(*created));
  }
  return outputs;
}

void printTables(const std::string& title, const verbs::CompareReport& report) {
  const verbs::Comparison& comparison = report.comparisons.back();
  print("{}\n\n", title);
  if (report.comparisons.size() > 1) {
    printTable(convergenceTable(report), "lr");
    return;
  }
  printTable(meshTable(report, comparison), "lr");
  print("\n");
  printTable(sliceTable(report, comparison), "r");
}

/// Prints the report and writes it to files.
int finish(const CompareArguments& options, Outputs& outputs, const std::string& title,
           verbs::CompareReport report) {
  if (outputs.html) {
    const ProgressBar bar("drawing");
    if (auto written = outputs.html->finish(comparePage(title, report)); !written) {
      return tools::report(written.error());
    }
  }
  if (outputs.csv) {
    if (auto written = outputs.csv->finish(csvOf(report)); !written) {
      return tools::report(written.error());
    }
  }
  if (options.json) {
    printAsJson(report);
  } else {
    printTables(title, report);
  }
  return kDone;
}

verbs::CompareOptions compareOptionsOf(const CompareArguments& options) {
  verbs::CompareOptions how{.slices = options.slices, .maxCells = options.maxCells};
  how.eachBody = options.eachBody;
  if (!options.times.empty()) how.times = *timesOf(options.times, kMaxSlices);
  if (!options.html.empty()) how.pairs = kPictures;
  return how;
}

verbs::MethodsOptions methodsOptionsOf(const CompareArguments& options) {
  verbs::MethodsOptions how{options.input, options.motion, options.table.table};
  if (options.rvMin) how.steps = mesh4d::MinVolumeRatio{*options.rvMin};
  if (options.steps) how.steps = mesh4d::StepsPerSegment{*options.steps};
  for (const std::string& caps : options.caps) {
    if (isVoxelCaps(caps)) {
      how.voxels.caps = voxelCapStyle(caps);
    } else if (caps == "cone") {
      how.meshCaps = mesh4d::CapMethod::Cone;
    }
  }
  how.voxelSizes = options.voxelSizes;
  how.voxels.times = options.frames;
  how.voxels.mask = options.mask;
  how.voxels.between = betweenOf(options.between);
  how.folder = options.keep;
  how.up = options.up;
  how.generator = versionText();
  return how;
}

int buildAndCompare(const CompareArguments& options, Outputs& outputs) {
  ConsoleObserver observer;
  SweepProcess process(options);
  auto done = verbs::compareMethods(
      methodsOptionsOf(options), compareOptionsOf(options),
      [&](const verbs::SweepOptions& sweep) { return process.make(sweep); }, observer);
  if (!done) {
    const int exitCode = report(done.error());
    return process.failed().value_or(exitCode);
  }
  std::string title = fmt::format("{} moved by {}", nameOf(options.input), nameOf(options.motion));
  if (done->compared.comparisons.size() == 1) {
    const verbs::ComparedMesh& woven = done->compared.comparisons.front().b;
    title += fmt::format(", voxels of {}, {}", *woven.voxelSize, counted(*woven.frames, "frame"));
  }
  const int exitCode = finish(options, outputs, title, std::move(done->compared));
  // The backends have reported the losses.
  return exitCode == kDone && !done->losses.empty() ? kLoss : exitCode;
}

int run(const CompareArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const std::array inputs = {options.input, options.other, options.motion};
  if (auto good = checkOutputs(std::array{options.html, options.csv}, inputs); !good) {
    return report(good.error());
  }
  auto outputs = createOutputs(options);
  if (!outputs) return report(outputs.error());
  if (options.builds()) return buildAndCompare(options, *outputs);
  ConsoleObserver observer;
  const std::array others = {verbs::ComparedFile{options.other}};
  auto compared = verbs::compare({options.input}, others, compareOptionsOf(options), observer);
  if (!compared) return report(compared.error());
  return finish(options, *outputs,
                fmt::format("{} and {}", nameOf(options.input), nameOf(options.other)),
                std::move(*compared));
}

}  // namespace

void addCompare(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "compare", "Compare two .t4d files, or both backends on one solid and motion");
  auto options = std::make_shared<CompareArguments>();
  command
      ->add_option("INPUT", options->input,
                   fmt::format("Solid for both backends ({}), or .t4d file (path or URL)",
                               formats::readableTriangleMeshExtensions()))
      ->required();
  command->add_option("OTHER", options->other, "Other .t4d file (path or URL)");
  command->add_option("-m,--motion", options->motion,
                      "Motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)");
  options->table.addTo(*command);
  command
      ->add_option("--voxel-size", options->voxelSizes,
                   "voxel4d: Voxel edge length, or several: 2,1,0.5, in length units")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(numberAboveZero());
  addFrameTimes(*command, options->frames, "voxel4d: ", kFramesByMotion);
  addMaxCellsOption(*command, options->maxCells);
  command->add_flag("--mask", options->mask,
                    "voxel4d: Use masks of inside points instead of level sets");
  addBetween(*command, options->between, "voxel4d: ");
  command
      ->add_option("--caps", options->caps,
                   "Caps of mesh4d (tetgen, cone) or voxel4d (the others); once for each")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step", "graded"}))
      ->allow_extra_args(false);
  auto* rvMin =
      command
          ->add_option(
              "--rv-min", options->rvMin,
              "mesh4d: Minimum slice volume relative to the solid, in [0, 1) (default: 0.998)")
          ->check(fractionBelowOne());
  command->add_option("--steps", options->steps, "mesh4d: Number of steps per segment")
      ->check(wholeNumber(1, mesh4d::kMaxSteps))
      ->excludes(rvMin);
  command->add_option("--up", options->up, "Axis of the solid that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  auto* slices = command
                     ->add_option("--slices", options->slices,
                                  "Number of evenly spaced times to compare (default: up to 9)")
                     ->check(wholeNumber(1, kMaxSlices));
  command
      ->add_option("--times", options->times,
                   "Compare N evenly spaced times from A to B, both included")
      ->check(timesUpTo(kMaxSlices))
      ->excludes(slices);
  command->add_option("--keep", options->keep, "Keep the .t4d files in this folder")
      ->check(someName());
  command
      ->add_option("--html", options->html,
                   "Write a page with tables, plots over time and pictures")
      ->check(htmlFile());
  command->add_option("--csv", options->csv, "Write a table with one row per time")
      ->check(outputFile({".csv"}));
  command->add_flag("--each-body", options->eachBody,
                    "Compare each body with that of the same name, in a row for each");
  addJsonOption<verbs::CompareReport>(
      *command, options->json,
      "Comparison of two 4D meshes: two files, or the meshes that both backends make of one solid "
      "(a: mesh4d, b: voxel4d, with the smallest voxels if there are several sizes). Lengths and "
      "times of both are in the units of a. Measures are null if they are too large for a double.");
  command->footer(
      "Examples:\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 0.5 --html bolt.html\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 2,1,0.5\n"
      "  t4d compare bolt.t4d bolt-voxels.t4d --times 0:2:5 --csv bolt.csv");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
