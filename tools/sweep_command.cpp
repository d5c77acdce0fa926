#include <chrono>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/motion_reader.h"
#include "formats/t4d/writer.h"
#include "formats/triangle_mesh_reader.h"
#include "mesh4d/sweep.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/version.h"

namespace t4d::tools {
namespace {

struct Options {
  std::string model;
  std::string motion;
  std::string output;
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::optional<double> maxDeviation;
  std::string caps = "tetgen";
  int prism = 14;
  std::string precision = "float64";
  int compression = 3;
  std::string up = "y";
  std::string body;
  bool json = false;
};

mesh4d::StepRule ruleOf(const Options& options) {
  if (options.steps) return mesh4d::StepsPerSegment{*options.steps};
  if (options.maxDeviation) return mesh4d::MaxDeviation{*options.maxDeviation};
  return mesh4d::MinVolumeRatio{options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio)};
}

/// What the file remembers of how it was made.
std::string detailsOf(const Options& options) {
  nlohmann::ordered_json parameters;
  if (options.steps) {
    parameters["steps"] = *options.steps;
  } else if (options.maxDeviation) {
    parameters["max_deviation"] = *options.maxDeviation;
  } else {
    parameters["rv_min"] = options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio);
  }
  parameters["caps"] = options.caps;
  parameters["prism"] = options.prism;
  parameters["precision"] = options.precision;
  const auto nameOf = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  return nlohmann::ordered_json{
      {"source", {{"mesh", nameOf(options.model)}, {"motion", nameOf(options.motion)}}},
      {"parameters", parameters}}
      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

int run(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = formats::readTriangleMesh(options.model);
  if (!loaded) return report(loaded.error());
  printNotices(loaded->notices);
  auto motion = formats::readMotion(options.motion);
  if (!motion) return report(motion.error());

  formats::Metadata metadata;
  metadata.generator = std::string(versionText());
  metadata.backend = "mesh4d";
  metadata.lengthUnit = motion->lengthUnit;
  metadata.timeUnit = motion->timeUnit;
  metadata.up = options.up;
  metadata.bodies = {options.body.empty() ? std::filesystem::path(options.model).stem().string()
                                          : options.body};
  metadata.detailsJson = detailsOf(options);
  auto writer = formats::T4dWriter::create(
      options.output, metadata,
      {.compression = options.compression, .float32 = options.precision == "float32"});
  if (!writer) return report(writer.error());

  Result<mesh4d::SweepReport> swept;
  {
    ProgressBar bar("sweeping");
    mesh4d::SweepOptions sweepOptions;
    sweepOptions.steps = ruleOf(options);
    sweepOptions.caps =
        options.caps == "cone" ? mesh4d::CapMethod::Cone : mesh4d::CapMethod::TetGen;
    sweepOptions.prism =
        options.prism == 3 ? mesh4d::PrismSplit::Three : mesh4d::PrismSplit::Fourteen;
    sweepOptions.progress = bar.callback();
    swept = mesh4d::sweep(loaded->mesh, *motion, sweepOptions, writer->body(0));
  }
  if (!swept) {
    Error error = swept.error();
    // What is wrong with a mesh is known without its file.
    if (error.where.empty()) error.where = options.model;
    return report(error);
  }
  auto bytes = writer->finish();
  if (!bytes) return report(bytes.error());
  printNotices(swept->notices);

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    printJson({{"vertices", swept->vertices},
               {"tetrahedra", swept->tetrahedra},
               {"steps", swept->steps},
               {"cap_tetrahedra", swept->capTetrahedra},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()},
               {"bytes", *bytes}});
  } else {
    fmt::print(
        "{}: {} vertices, {} tetrahedra\n  {} steps, caps of {} and {} tetrahedra\n  {}, {:.2f} s, "
        "peak memory {}\n",
        options.output, grouped(swept->vertices), grouped(swept->tetrahedra), grouped(swept->steps),
        grouped(swept->capTetrahedra[0]), grouped(swept->capTetrahedra[1]), sizeText(*bytes),
        seconds, sizeText(peakBytes()));
  }
  return kDone;
}

}  // namespace

void addSweep(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "sweep", "Sweep a closed triangle mesh along a rigid motion into a 4D mesh");
  auto options = std::make_shared<Options>();
  command->add_option("MODEL", options->model, "The solid: .stl, .obj, .ply, .off, .gltf or .glb")
      ->required();
  command->add_option("-m,--motion", options->motion, "The motion: a JSON file (docs/motion.md)")
      ->required();
  command->add_option("-o,--output", options->output, "The .t4d file to write")->required();
  auto* rvMin = command->add_option(
      "--rv-min", options->rvMin,
      "Smallest volume of any slice, as a fraction of the solid's, in [0, 1) (default: 0.998)");
  auto* steps = command->add_option("--steps", options->steps, "Steps for each segment");
  auto* deviation = command->add_option("--max-deviation", options->maxDeviation,
                                        "Largest distance of a point from its true path");
  rvMin->excludes(steps)->excludes(deviation);
  steps->excludes(deviation);
  command
      ->add_option("--caps", options->caps,
                   "How the ends are closed: tetgen, or cone for meshes that intersect themselves")
      ->check(CLI::IsMember({"tetgen", "cone"}))
      ->capture_default_str();
  command
      ->add_option("--prism", options->prism,
                   "Cells of a triangle's prism: 14 (symmetric, exact volumes) or 3 (smallest)")
      ->check(CLI::IsMember({14, 3}))
      ->capture_default_str();
  command->add_option("--precision", options->precision, "Positions as float64 or float32")
      ->check(CLI::IsMember({"float64", "float32"}))
      ->capture_default_str();
  command->add_option("--compression", options->compression, "zstd level, 0 for none")
      ->check(CLI::Range(0, 19))
      ->capture_default_str();
  command->add_option("--up", options->up, "The mesh's axis that points up, for glTF: y or z")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  command->add_option("--body", options->body, "Name of the body (default: the model's file name)");
  command->add_flag("--json", options->json, "Print what was made as JSON");
  command->footer("Example:\n  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
