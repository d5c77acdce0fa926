#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <tuple>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/motion_reader.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle_mesh_reader.h"
#include "t4d/measure/compare.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/mesh4d/steps.h"
#include "t4d/system/child_process.h"
#include "t4d/system/temporary_folder.h"
#include "t4d/voxel4d/voxelize.h"
#include "tools/program/commands.h"
#include "tools/program/compare_page.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::uint64_t kMaxSlices = 100'000;
/// Pairs of solids that the page has pictures of.
constexpr std::size_t kPictures = 3;

struct Options {
  std::string input;
  std::string other;  // "" for both backends on `input`
  std::string motion;
  std::optional<double> voxelSize;
  std::optional<std::uint64_t> frames;
  std::optional<double> frameTime;
  bool mask = false;
  std::vector<std::string> caps;
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::string up = "y";
  std::uint64_t slices = 9;
  std::string times;
  std::string keep;
  std::string html;
  bool json = false;

  bool builds() const { return other.empty(); }
};

/// The three numbers of a:b:n, n a whole number from 1 to kMaxSlices.
std::optional<std::vector<double>> timesOf(const std::string& text) {
  auto numbers = numbersBetween(text, ':');
  if (!numbers || numbers->size() != 3) return std::nullopt;
  const double n = (*numbers)[2];
  if (!(n >= 1 && n <= static_cast<double>(kMaxSlices)) || n != std::floor(n)) return std::nullopt;
  return convert::evenTimes((*numbers)[0], (*numbers)[1], static_cast<std::size_t>(n));
}

/// Options that do not go together; a reason for exit code 2.
std::optional<std::string> misuseOf(const Options& options) {
  if (options.builds()) {
    if (options.motion.empty() || !options.voxelSize || !options.frames) {
      return "one solid needs --motion, --voxel-size and --frames; or give two .t4d files";
    }
    return std::nullopt;
  }
  if (!options.motion.empty() || options.voxelSize || options.frames || options.mask ||
      !options.caps.empty() || options.rvMin || options.steps || !options.keep.empty()) {
    return "--motion, --voxel-size, --frames, --mask, --caps, --rv-min, --steps and --keep are for "
           "one solid; two .t4d files are compared as they are";
  }
  return std::nullopt;
}

/// A 4D mesh that a backend has just made.
struct Built {
  fs::path path;
  double seconds = 0;
  std::uint64_t peakBytes = 0;
};

/// Has one backend make its mesh in a process of its own, which has said what went wrong where it
/// has failed: then the result is its exit code.
Result<std::variant<Built, int>> build(const Options& options, const fs::path& folder,
                                       const std::string& backend) {
  Built built;
  built.path = folder / fmt::format("{}-{}.t4d", fs::path(options.input).stem().string(), backend);
  std::vector<std::string> arguments = {
      "sweep", options.input, "--motion", options.motion,      "--backend", backend,
      "--up",  options.up,    "-o",       built.path.string(), "--json"};
  const auto add = [&](const char* name, const std::string& value) {
    arguments.emplace_back(name);
    arguments.push_back(value);
  };
  const bool voxels = backend == "voxel4d";
  if (voxels) {
    add("--voxel-size", fmt::format("{}", *options.voxelSize));
    add("--frames", fmt::format("{}", *options.frames));
    if (options.frameTime) add("--frame-time", fmt::format("{}", *options.frameTime));
    if (options.mask) arguments.emplace_back("--mask");
  } else {
    if (options.rvMin) add("--rv-min", fmt::format("{}", *options.rvMin));
    if (options.steps) add("--steps", fmt::format("{}", *options.steps));
  }
  for (const std::string& caps : options.caps) {
    if (voxels == (caps == "flat" || caps == "half-step")) add("--caps", caps);
  }
  const auto finished = system::runSelf(arguments);
  if (!finished) return pass(finished.error());
  if (finished->code != kDone) {
    say("the backend " + backend + " made no 4D mesh");
    return finished->code;
  }
  const auto said = ordered_json::parse(finished->output, nullptr, false);
  if (!said.is_object() || !said.contains("seconds") || !said.contains("peak_bytes")) {
    return fail(ErrorCode::Failed, "`t4d sweep --json` did not say how long it took");
  }
  built.seconds = said["seconds"];
  built.peakBytes = said["peak_bytes"];
  return built;
}

/// Reads and measures a file. A mesh that is not sound is measured too, with a notice.
Result<ComparedMesh> measure(InputBodies& input, const std::string& path) {
  ComparedMesh mesh;
  mesh.name = fs::path(path).filename().string();
  mesh.backend = input.reader.metadata().backend;
  mesh.bytes = input.reader.fileBytes();
  ProgressBar bar("measuring " + mesh.name);
  for (const model::Body& body : input.bodies) {
    auto report = measure::checkMesh(*body.source, {}, bar.callback());
    if (!report) {
      Error error = report.error();
      if (error.where.empty()) error.where = path;
      return pass(error);
    }
    mesh.vertices += report->vertices;
    mesh.tetrahedra += report->tetrahedra;
    mesh.hypervolume += report->hypervolume;
    if (!report->valid()) {
      printNotices(
          {fmt::format("{}: body '{}' is not a closed, oriented 4D mesh; `t4d validate` "
                       "says why",
                       path, body.name)});
    }
  }
  return mesh;
}

/// The true moving solid: its volume never changes.
struct Truth {
  double volume = 0;
  double duration = 0;
  std::string lengthUnit;
  std::string timeUnit;
};

Result<Truth> truthOf(const Options& options) {
  auto loaded = formats::readTriangleMesh(options.input);
  if (!loaded) return pass(loaded.error());
  auto motion = formats::readMotion(options.motion);
  if (!motion) return pass(motion.error());
  return Truth{std::abs(signedVolume(loaded->mesh)), motion->timeEnd() - motion->timeBegin(),
               motion->lengthUnit, motion->timeUnit};
}

template <class T>
ordered_json orNull(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json();
}

ordered_json jsonOf(const ComparedMesh& mesh) {
  ordered_json value = {{"backend", mesh.backend},         {"vertices", mesh.vertices},
                        {"tetrahedra", mesh.tetrahedra},   {"bytes", mesh.bytes},
                        {"seconds", orNull(mesh.seconds)}, {"peak_bytes", orNull(mesh.peakBytes)},
                        {"hypervolume", mesh.hypervolume}};
  if (mesh.hypervolumeExpected) value["hypervolume_expected"] = *mesh.hypervolumeExpected;
  if (const auto error = mesh.hypervolumeError()) value["hypervolume_error"] = *error;
  return value;
}

ordered_json jsonOf(const Comparison& comparison) {
  ordered_json slices = ordered_json::array();
  for (const measure::SliceComparison& slice : comparison.slices) {
    const double hausdorff = slice.distance.hausdorff();
    slices.push_back(
        {{"time", slice.time},
         {"volume_a", slice.volumeA},
         {"volume_b", slice.volumeB},
         {"area_a", slice.areaA},
         {"area_b", slice.areaB},
         {"symmetric_difference", slice.difference.volume},
         {"hausdorff", std::isfinite(hausdorff) ? ordered_json(hausdorff) : ordered_json()}});
  }
  return {{"a", jsonOf(comparison.a)}, {"b", jsonOf(comparison.b)}, {"slices", slices}};
}

void printText(const Comparison& comparison) {
  std::vector<std::vector<std::string>> meshes = {{"", "a", "b", "b / a"}};
  for (const CompareRow& row : compareRows(comparison)) {
    meshes.push_back({row.label, row.a, row.b, row.ratio});
  }
  fmt::print("{}\n\n", comparison.title);
  printTable(meshes, "lr");
  fmt::print("\n");
  std::vector<std::vector<std::string>> slices = {sliceColumns()};
  for (const measure::SliceComparison& slice : comparison.slices) slices.push_back(sliceRow(slice));
  printTable(slices, "r");
}

/// The solids at the first, a middle and the last of the times.
Result<std::vector<SolidPair>> pairsToShow(const InputBodies& a, const InputBodies& b,
                                           const std::vector<double>& times) {
  std::vector<SolidPair> pairs;
  const std::size_t count = std::min(kPictures, times.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = count == 1 ? 0 : i * (times.size() - 1) / (count - 1);
    auto solidOfA = measure::solidAt(a.bodies, times[at]);
    if (!solidOfA) return pass(solidOfA.error());
    auto solidOfB = measure::solidAt(b.bodies, times[at]);
    if (!solidOfB) return pass(solidOfB.error());
    pairs.push_back({times[at], std::move(*solidOfA), std::move(*solidOfB)});
  }
  return pairs;
}

int compareFiles(const Options& options, const std::array<std::string, 2>& paths,
                 Comparison comparison) {
  std::optional<formats::OutputFile> page;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    page.emplace(std::move(*created));
  }
  auto a = openBodies(paths[0], {});
  if (!a) return report(a.error());
  auto b = openBodies(paths[1], {});
  if (!b) return report(b.error());
  for (const auto& [input, path, mesh] :
       {std::tuple{&*a, &paths[0], &comparison.a}, std::tuple{&*b, &paths[1], &comparison.b}}) {
    auto measured = measure(*input, *path);
    if (!measured) return report(measured.error());
    measured->seconds = mesh->seconds;
    measured->peakBytes = mesh->peakBytes;
    measured->hypervolumeExpected = mesh->hypervolumeExpected;
    if (options.builds() && options.keep.empty()) measured->name.clear();
    *mesh = std::move(*measured);
  }

  std::vector<model::Body> all = a->bodies;
  all.insert(all.end(), b->bodies.begin(), b->bodies.end());
  const model::TimeSpan span = model::timeSpanOf(all);
  const std::vector<double> times = options.times.empty()
                                        ? convert::evenTimes(span.begin, span.end, options.slices)
                                        : *timesOf(options.times);
  for (const double time : times) {
    if (time >= span.begin && time <= span.end) continue;
    return report({ErrorCode::InvalidInput,
                   fmt::format("nothing exists at time {}; the meshes last from {} to {}", time,
                               span.begin, span.end),
                   {},
                   {}});
  }
  {
    ProgressBar bar("comparing");
    auto slices = measure::compareAt(a->bodies, b->bodies, times, {}, bar.callback());
    if (!slices) return report(slices.error());
    comparison.slices = std::move(*slices);
  }
  if (page) {
    auto pairs = pairsToShow(*a, *b, times);
    if (!pairs) return report(pairs.error());
    const bool zUp = a->reader.metadata().up == "z";
    const std::string html = comparePage(comparison, *pairs, zUp);
    auto written = page->write(html.data(), html.size()).and_then([&] { return page->commit(); });
    if (!written) return report(written.error());
  }
  if (options.json) {
    printJson(jsonOf(comparison));
  } else {
    printText(comparison);
  }
  return kDone;
}

int buildAndCompare(const Options& options) {
  auto truth = truthOf(options);
  if (!truth) return report(truth.error());
  std::optional<system::TemporaryFolder> temporary;
  fs::path folder = options.keep;
  if (options.keep.empty()) {
    auto created = system::TemporaryFolder::create();
    if (!created) return report(created.error());
    folder = created->path();
    temporary.emplace(std::move(*created));
  } else {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      return report(
          {ErrorCode::Failed, "cannot make the folder: " + error.message(), options.keep, {}});
    }
  }

  Comparison comparison;
  comparison.title =
      fmt::format("{} moved by {}, voxels of {}, {}", fs::path(options.input).filename().string(),
                  fs::path(options.motion).filename().string(), *options.voxelSize,
                  counted(*options.frames, "frame"));
  comparison.volumeExpected = truth->volume;
  comparison.lengthUnit = truth->lengthUnit;
  comparison.timeUnit = truth->timeUnit;
  std::array<std::string, 2> paths;
  for (const auto& [backend, mesh, path] : {std::tuple{"mesh4d", &comparison.a, &paths[0]},
                                            std::tuple{"voxel4d", &comparison.b, &paths[1]}}) {
    auto built = build(options, folder, backend);
    if (!built) return report(built.error());
    if (const int* exitCode = std::get_if<int>(&*built)) return *exitCode;
    const Built& done = std::get<Built>(*built);
    *path = done.path.string();
    mesh->seconds = done.seconds;
    mesh->peakBytes = done.peakBytes;
    mesh->hypervolumeExpected = truth->volume * truth->duration;
  }
  return compareFiles(options, paths, std::move(comparison));
}

int run(const Options& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  if (const auto misuse =
          misuseOfOutput(options.html, std::array{options.input, options.other, options.motion})) {
    return wrongUsage(*misuse);
  }
  if (options.builds()) return buildAndCompare(options);
  Comparison comparison;
  comparison.title = fmt::format("{} and {}", fs::path(options.input).filename().string(),
                                 fs::path(options.other).filename().string());
  return compareFiles(options, {options.input, options.other}, std::move(comparison));
}

}  // namespace

void addCompare(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "compare", "Compare two 4D meshes: two files, or both backends on one solid and motion");
  auto options = std::make_shared<Options>();
  command
      ->add_option(
          "INPUT", options->input,
          "A solid (.stl, .obj, .ply, .off, .gltf, .glb) for both backends, or a .t4d file")
      ->required();
  command->add_option("OTHER", options->other, "The .t4d file to compare it with");
  command->add_option("-m,--motion", options->motion, "The motion: a JSON file (docs/motion.md)");
  command
      ->add_option("--voxel-size", options->voxelSize, "voxel4d: edge of a voxel, in length units")
      ->check(numberAboveZero());
  command->add_option("--frames", options->frames, "voxel4d: frames, evenly over the motion")
      ->check(wholeNumber(2, voxel4d::kMaxFrames));
  command
      ->add_option("--frame-time", options->frameTime,
                   "voxel4d: frames so far apart, from the first time on")
      ->check(numberAboveZero());
  command->add_flag("--mask", options->mask,
                    "voxel4d: which lattice points are inside, instead of level sets");
  command
      ->add_option("--caps", options->caps,
                   "How the ends are closed, of mesh4d (tetgen, cone) or voxel4d (flat, "
                   "half-step); may be given for each")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step"}))
      ->allow_extra_args(false);
  auto* rvMin = command
                    ->add_option("--rv-min", options->rvMin,
                                 "mesh4d: smallest volume of any slice, as a fraction")
                    ->check(fractionBelowOne());
  command->add_option("--steps", options->steps, "mesh4d: steps for each segment")
      ->check(wholeNumber(1, mesh4d::kMaxSteps))
      ->excludes(rvMin);
  command->add_option("--up", options->up, "The solid's axis that points up: y or z")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  auto* slices = command
                     ->add_option("--slices", options->slices,
                                  "Times to compare at, evenly from first to last")
                     ->check(wholeNumber(1, kMaxSlices))
                     ->capture_default_str();
  command->add_option("--times", options->times, "a:b:n, n times evenly from a to b, both included")
      ->check(CLI::Validator(
          [](std::string& text) {
            return timesOf(text) ? std::string() : "'" + text + "' is not a:b:n with n from 1 on";
          },
          "A:B:N"))
      ->excludes(slices);
  command->add_option("--keep", options->keep, "A folder to leave the two .t4d files in")
      ->check(someName());
  command
      ->add_option("--html", options->html,
                   "A page to write: the tables, plots over time, pictures of the solids")
      ->check(someName());
  command->add_flag("--json", options->json, "Print the comparison as JSON");
  command->footer(
      "Example:\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 0.5 --frames 60 --html "
      "bolt.html\n"
      "  t4d compare bolt.t4d bolt-voxels.t4d --times 0:2:5");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
