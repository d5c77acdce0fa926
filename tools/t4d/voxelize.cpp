#include "tools/t4d/voxelize.h"

#include <utility>

#include "t4d/weave.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/motion_frames.h"
#include "tools/t4d/moving_mesh.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {
Result<VoxelSeriesReport> voxelize(model::TriangleMesh mesh, model::Motion motion,
                                   const VoxelSeriesOptions& options, Observer& observer) {
  return writeVoxelSeries(voxel4d::movingSolid(std::move(mesh), std::move(motion)), options,
                          observer);
}

void describe(Members& members, const VoxelizeReport& report) {
  members("mend", report.mended, "With --mend: the changes to the solid, as in t4d mend --json.",
          addMending)
      .onlyIf(!report.mended.empty());
  describe(members, report.written);
}

namespace {

struct VoxelizeArguments {
  MovingMeshArguments input;
  VoxelSeriesArguments series;
};

int run(const VoxelizeArguments& options) {
  auto loaded = options.input.read();
  if (!loaded) return report(loaded.error());
  model::TriangleMesh& mesh = loaded->solid.bodies.front().mesh;
  std::vector<std::string> notices;
  const auto times = motionFrameTimes(options.series.times, options.series.write.voxelSize, mesh,
                                      loaded->motion, options.input.motion, notices);
  if (!times) return report(times.error());
  printNotices(notices);
  if (const auto done = options.series.part.settle(times->size(), "frames")) {
    return *done == kDone ? reportLosses(loaded->solid.losses) : *done;
  }
  ConsoleObserver observer;
  const auto written = voxelize(std::move(mesh), std::move(loaded->motion),
                                options.series.at(*times, options.input.model), observer);
  if (!written) return report(written.error());
  const int done =
      reportVoxelSeries(options.series, times->size(), *written,
                        Members::valueOf(VoxelizeReport{*written, loaded->solid.mended}));
  return done == kDone ? reportLosses(loaded->solid.losses) : done;
}

}  // namespace

void addVoxelize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "voxelize", "Write a moving triangle mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<VoxelizeArguments>();
  options->input.addTo(*command);
  options->series.addTo(*command);
  addJsonOption<VoxelizeReport>(
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
