#include <array>
#include <chrono>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/mesh4d/sweep.h"
#include "t4d/voxel4d/voxelize.h"
#include "t4d/voxel4d/weave.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/moving_mesh.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"
#include "tools/program/thread_limit.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct SweepArguments {
  MovingMeshInput input;
  std::string backend = "mesh4d";
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::optional<double> maxDeviation;
  std::string caps;  // "" for the backend's default
  std::optional<int> prism;
  std::string part;  // "" for everything
  std::optional<double> voxelSize;
  voxel4d::FrameTimes times;
  bool mask = false;
  std::optional<int> threads;
  T4dOutput output;
  bool json = false;

  bool voxels() const { return backend == "voxel4d"; }
};

/// The result of either backend.
struct Made {
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};
  std::vector<std::string> notices;
};

/// The error message if the options cannot be combined; nothing if they can.
std::optional<std::string> misuseOf(const SweepArguments& options) {
  if (options.voxels()) {
    if (!options.voxelSize) return "--backend voxel4d needs --voxel-size";
    if (!options.part.empty()) return "--part is for --backend mesh4d";
    return std::nullopt;
  }
  if (options.voxelSize || options.times.count || options.times.step || options.mask) {
    return "--voxel-size, --frames, --frame-time and --mask are for --backend voxel4d";
  }
  if (!options.part.empty() && options.output.center) {
    return "--part and --center exclude each other: the parts would not meet";
  }
  if (isVoxelCaps(options.caps)) {
    return "--caps " + options.caps + " is for --backend voxel4d; mesh4d has tetgen and cone";
  }
  return std::nullopt;
}

/// SweepArguments that voxel4d ignores, so that both backends accept the same arguments.
std::vector<std::string> ignoredBy(const SweepArguments& options) {
  std::vector<std::string> names;
  if (options.rvMin) names.emplace_back("--rv-min");
  if (options.steps) names.emplace_back("--steps");
  if (options.maxDeviation) names.emplace_back("--max-deviation");
  if (options.prism) names.emplace_back("--prism");
  if (!options.caps.empty() && !isVoxelCaps(options.caps)) names.emplace_back("--caps");
  return names;
}

mesh4d::StepRule ruleOf(const SweepArguments& options) {
  if (options.steps) return mesh4d::StepsPerSegment{*options.steps};
  if (options.maxDeviation) return mesh4d::MaxDeviation{*options.maxDeviation};
  return mesh4d::MinVolumeRatio{options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio)};
}

/// How the file was made, for its metadata.
std::string detailsOf(const SweepArguments& options) {
  ordered_json parameters;
  if (options.voxels()) {
    parameters["voxel_size"] = *options.voxelSize;
    if (options.times.count) parameters["frames"] = *options.times.count;
    if (options.times.step) parameters["frame_time"] = *options.times.step;
    parameters["mask"] = options.mask;
    parameters["caps"] = isVoxelCaps(options.caps) ? options.caps : voxelCaps().front();
  } else {
    if (options.steps) {
      parameters["steps"] = *options.steps;
    } else if (options.maxDeviation) {
      parameters["max_deviation"] = *options.maxDeviation;
    } else {
      parameters["rv_min"] = options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio);
    }
    parameters["caps"] = options.caps == "cone" ? "cone" : "tetgen";
    parameters["prism"] = options.prism.value_or(14);
  }
  parameters["precision"] = options.output.precision;
  if (options.output.grid) parameters["grid"] = *options.output.grid;
  const auto nameOf = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  return ordered_json{
      {"source", {{"mesh", nameOf(options.input.model)}, {"motion", nameOf(options.input.motion)}}},
      {"parameters", parameters}}
      .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

Result<Made> sweepMesh(const SweepArguments& options, const model::TriangleMesh& mesh,
                       const model::Motion& motion, model::Sink& sink) {
  ProgressBar bar("sweeping");
  mesh4d::SweepOptions how;
  how.steps = ruleOf(options);
  how.caps = options.caps == "cone" ? mesh4d::CapMethod::Cone : mesh4d::CapMethod::TetGen;
  how.prism = options.prism == 3 ? mesh4d::PrismSplit::Three : mesh4d::PrismSplit::Fourteen;
  if (const auto part = numbersBetween(options.part, '/')) {
    how.part = {static_cast<std::uint64_t>((*part)[0]), static_cast<std::uint64_t>((*part)[1])};
  }
  auto report = mesh4d::sweep(mesh, motion, how, sink, bar.callback());
  if (!report) return pass(report.error());
  return Made{report->vertices, report->tetrahedra, report->steps, report->capTetrahedra,
              report->notices};
}

Result<Made> sweepVoxels(const SweepArguments& options, const model::TriangleMesh& mesh,
                         const model::Motion& motion, model::Sink& sink) {
  Made made;
  auto times = motionFrameTimes(options.times, *options.voxelSize, mesh, motion,
                                options.input.motion, made.notices);
  if (!times) return pass(times.error());
  if (const auto ignored = ignoredBy(options); !ignored.empty()) {
    made.notices.push_back(fmt::format("voxel4d ignores {}", fmt::join(ignored, ", ")));
  }
  const auto frames = voxel4d::voxelFrames(voxel4d::movingSolid(mesh, motion), std::move(*times),
                                           {*options.voxelSize, options.mask});
  ProgressBar bar("voxelising and weaving");
  voxel4d::WeaveOptions how;
  how.caps = voxelCapStyle(options.caps);
  auto report = voxel4d::weave(*frames, how, sink, bar.callback());
  if (!report) return pass(report.error());
  noticeCaps(how.caps, *report, made.notices);
  made.vertices = report->vertices;
  made.tetrahedra = report->tetrahedra;
  made.steps = report->frames - 1;
  made.capTetrahedra = report->capTetrahedra;
  return made;
}

int run(const SweepArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  if (const auto misuse = misuseOfOutput(options.output.path,
                                         std::array{options.input.model, options.input.motion})) {
    return wrongUsage(*misuse);
  }
  const auto begin = std::chrono::steady_clock::now();
  const ThreadLimit limit(options.threads);
  auto loaded = options.input.read();
  if (!loaded) return report(loaded.error());
  if (const auto misuse = misuseOfOutput(options.output.path, loaded->files)) {
    return wrongUsage(*misuse);
  }
  const model::Motion& motion = loaded->motion;
  auto file =
      T4dFile::create(options.output, {options.backend, options.input.model, motion.lengthUnit,
                                       motion.timeUnit, detailsOf(options)});
  if (!file) return report(file.error());

  auto made = options.voxels() ? sweepVoxels(options, loaded->mesh, motion, *file)
                               : sweepMesh(options, loaded->mesh, motion, *file);
  if (!made) {
    Error error = made.error();
    // Errors about the mesh or the motion do not name its file.
    const bool motionsFault = error.remedy == Remedy::Motion || error.remedy == Remedy::StepRule;
    if (error.where.empty()) {
      error.where = motionsFault ? options.input.motion : options.input.model;
    }
    return report(error);
  }
  auto bytes = file->finish();
  if (!bytes) return report(bytes.error());
  printNotices(made->notices);

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    printJson({{"vertices", made->vertices},
               {"tetrahedra", made->tetrahedra},
               {"steps", made->steps},
               {"cap_tetrahedra", made->capTetrahedra},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()},
               {"bytes", *bytes}});
  } else {
    print("{}: {} vertices, {} tetrahedra\n", options.output.path, grouped(made->vertices),
          grouped(made->tetrahedra));
    print("  {}, caps of {} and {} tetrahedra\n", counted(made->steps, "step"),
          grouped(made->capTetrahedra[0]), grouped(made->capTetrahedra[1]));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
    if (const auto rounding = options.output.rounding()) print("  {}\n", *rounding);
  }
  std::vector<std::string> losses = std::move(loaded->losses);
  for (std::string& loss : file->losses()) losses.push_back(std::move(loss));
  return reportLosses(losses);
}

}  // namespace

void addSweep(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "sweep", "Sweep a closed triangle mesh along a rigid motion into a 4D mesh");
  auto options = std::make_shared<SweepArguments>();
  options->input.addTo(*command);
  command
      ->add_option("--backend", options->backend,
                   "mesh4d (sweep the triangles) or voxel4d (weave a time series of voxel grids)")
      ->check(CLI::IsMember({"mesh4d", "voxel4d"}))
      ->capture_default_str();
  auto* rvMin = command
                    ->add_option("--rv-min", options->rvMin,
                                 "Smallest volume of any slice, as a fraction of the solid's, in "
                                 "[0, 1) (default: 0.998)")
                    ->check(fractionBelowOne());
  auto* steps = command->add_option("--steps", options->steps, "Number of steps of each segment")
                    ->check(wholeNumber(1, mesh4d::kMaxSteps));
  auto* deviation = command
                        ->add_option("--max-deviation", options->maxDeviation,
                                     "Largest distance of a point from its true path")
                        ->check(numberAboveZero());
  rvMin->excludes(steps)->excludes(deviation);
  steps->excludes(deviation);
  command
      ->add_option(
          "--caps", options->caps,
          "How to close the ends. mesh4d: tetgen (default), or cone for meshes that "
          "intersect themselves; voxel4d: flat (default), graded (flat, with cells that grow "
          "inwards), or half-step as in the paper")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step", "graded"}));
  command
      ->add_option("--prism", options->prism,
                   "Cells per prism: 14 (default; symmetric, exact volumes) or 3 (smallest files)")
      ->check(CLI::IsMember({14, 3}));
  command
      ->add_option("--part", options->part,
                   "Sweep only part K of N, each with as many steps; `t4d join` joins their files")
      ->check(partOf())
      ->type_name("K/N");
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "voxel4d: Edge length of a voxel, in length units")
      ->check(numberAboveZero());
  addFrameTimes(*command, options->times, "voxel4d: ", kFramesByMotion);
  command->add_flag("--mask", options->mask,
                    "voxel4d: Use masks of the lattice points inside, instead of level sets");
  addThreadsOption(*command, options->threads);
  options->output.addTo(*command);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d\n"
      "  t4d sweep bolt.obj --motion screw-in.json --backend voxel4d --voxel-size 0.5 "
      "-o bolt-voxels.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
