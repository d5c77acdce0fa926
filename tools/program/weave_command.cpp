#include <chrono>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/voxel4d/vdb_frames.h"
#include "t4d/voxel4d/weave.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"
#include "tools/program/thread_limit.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct WeaveArguments {
  std::vector<std::string> frames;
  voxel4d::VdbFramesOptions input;
  std::string caps = "flat";
  std::string lengthUnit;
  std::string timeUnit;
  std::optional<int> threads;
  T4dOutput output;
  bool json = false;
};

std::string detailsOf(const WeaveArguments& options) {
  ordered_json parameters;
  if (options.input.iso) parameters["iso"] = *options.input.iso;
  parameters["caps"] = options.caps;
  parameters["precision"] = options.output.precision;
  if (options.output.grid) parameters["grid"] = *options.output.grid;
  const std::string first = nameIn(options.frames.front()).string();
  return ordered_json{{"source", {{"frames", first}}}, {"parameters", parameters}}.dump(
      -1, ' ', false, ordered_json::error_handler_t::replace);
}

int run(const WeaveArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output.path, options.frames)) {
    return wrongUsage(*misuse);
  }
  const auto begin = std::chrono::steady_clock::now();
  const ThreadLimit limit(options.threads);
  const std::vector<std::filesystem::path> inputs(options.frames.begin(), options.frames.end());
  auto frames = voxel4d::openVdbFrames(inputs, options.input);
  if (!frames) return report(frames.error());
  auto file =
      T4dFile::create(options.output, {"voxel4d", options.frames.front(), options.lengthUnit,
                                       options.timeUnit, detailsOf(options)});
  if (!file) return report(file.error());
  const voxel4d::CapStyle caps = voxelCapStyle(options.caps);
  Result<voxel4d::WeaveReport> woven;
  {
    ProgressBar bar("weaving");
    woven = voxel4d::weave(**frames, {caps}, *file, bar.callback());
  }
  if (!woven) return report(woven.error());
  auto bytes = file->finish();
  if (!bytes) return report(bytes.error());
  std::vector<std::string> notices;
  noticeCaps(caps, *woven, notices);
  printNotices(notices);

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    printJson({{"vertices", woven->vertices},
               {"tetrahedra", woven->tetrahedra},
               {"frames", woven->frames},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()},
               {"cap_tetrahedra", woven->capTetrahedra},
               {"bytes", *bytes}});
  } else {
    print("{}: {} vertices, {} tetrahedra from {}\n", options.output.path, grouped(woven->vertices),
          grouped(woven->tetrahedra), counted(woven->frames, "frame"));
    print("  caps of {} and {} tetrahedra\n", grouped(woven->capTetrahedra[0]),
          grouped(woven->capTetrahedra[1]));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
    if (const auto rounding = options.output.rounding()) print("  {}\n", *rounding);
  }
  return reportLosses(file->losses());
}

}  // namespace

void addWeave(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("weave", "Weave a time series of OpenVDB grids into a 4D mesh");
  auto options = std::make_shared<WeaveArguments>();
  command
      ->add_option("FRAMES", options->frames,
                   "The grids: .vdb files with one frame each, a folder of them, or one file with "
                   "several grids")
      ->required();
  command
      ->add_option(
          "--iso", options->input.iso,
          "Grids are densities; inside is where they are above this value (default: level sets, "
          "inside is where they are below 0)")
      ->check(finiteNumber());
  auto* frameTime =
      command
          ->add_option("--frame-time", options->input.frameTime,
                       "Time between frames (default: the times in the grids' metadata "
                       "t4d_time)")
          ->check(numberAboveZero());
  command
      ->add_option("--start-time", options->input.startTime, "Time of the first frame (default: 0)")
      ->check(finiteNumber())
      ->needs(frameTime);
  command->add_option("--grid", options->input.grid, "Only grids with this name (default: all)");
  command
      ->add_option("--caps", options->caps,
                   "How to close the ends: flat; graded (flat, with cells that grow inwards); or "
                   "half-step as in the paper")
      ->check(CLI::IsMember(voxelCaps()))
      ->capture_default_str();
  command->add_option("--length-unit", options->lengthUnit, "Length unit of the grids: mm, m, ...");
  command->add_option("--time-unit", options->timeUnit, "Unit of the times: s, min, ...");
  addThreadsOption(*command, options->threads);
  options->output.addTo(*command);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer("Example:\n  t4d weave frames/*.vdb -o moving.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
