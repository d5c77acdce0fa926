#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/moving_mesh.h"
#include "tools/t4d/voxel_series.h"
#include "tools/verbs/mending.h"
#include "tools/verbs/motion_frames.h"
#include "tools/verbs/voxelize.h"

namespace t4d::tools {
namespace {

struct VoxelizeArguments {
  MovingMeshInput input;
  VoxelSeriesOptions series;
};

int run(const VoxelizeArguments& options) {
  auto loaded = options.input.read();
  if (!loaded) return report(loaded.error());
  model::TriangleMesh& mesh = loaded->solid.bodies.front().mesh;
  std::vector<std::string> notices;
  const auto times = verbs::motionFrameTimes(options.series.times, options.series.voxelSize, mesh,
                                             loaded->motion, options.input.motion, notices);
  if (!times) return report(times.error());
  printNotices(notices);
  if (const auto done = options.series.part.settle(times->size(), "frames")) {
    return *done == kDone ? reportLosses(loaded->solid.losses) : *done;
  }
  ConsoleObserver observer;
  const auto written = verbs::voxelize(std::move(mesh), std::move(loaded->motion),
                                       options.series.at(*times, options.input.model), observer);
  if (!written) return report(written.error());
  const int done = reportVoxelSeries(
      options.series, times->size(), *written,
      verbs::Members::valueOf(verbs::VoxelizeReport{*written, loaded->solid.mended}));
  return done == kDone ? reportLosses(loaded->solid.losses) : done;
}

}  // namespace

void addVoxelize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "voxelize", "Write a moving triangle mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<VoxelizeArguments>();
  options->input.addTo(*command);
  options->series.addTo(*command);
  addJsonOption<verbs::VoxelizeReport>(
      *command, options->series.json,
      "The time series of OpenVDB grids that was made of a moving solid, one file each.");
  addFrameTimes(*command, options->series.times, "", kFramesByMotion);
  command->footer(
      "Example:\n  t4d voxelize bolt.obj --motion screw-in.json --voxel-size 0.25 -o bolt-frames\n"
      "  t4d voxelize bolt.obj --motion screw-in.json --voxel-size 0.25 --frames 60 --mask -o "
      "bolt-masks");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
