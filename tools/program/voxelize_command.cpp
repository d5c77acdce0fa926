#include "t4d/formats/motion_reader.h"
#include "t4d/formats/triangle_mesh_formats.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

struct Options {
  std::string model;
  std::string motion;
  VoxelSeriesOptions series;
};

int run(const Options& options) {
  auto loaded = formats::readTriangleMesh(options.model);
  if (!loaded) return report(loaded.error());
  printNotices(loaded->notices);
  auto motion = formats::readMotion(options.motion);
  if (!motion) return report(motion.error());
  std::vector<std::string> notices;
  const auto times = motionFrameTimes(options.series.times, options.series.voxelSize, loaded->mesh,
                                      *motion, notices);
  if (!times) return report(times.error());
  printNotices(notices);
  const int done = writeVoxelSeries(
      options.series, *times, voxel4d::movingSolid(std::move(loaded->mesh), std::move(*motion)),
      options.model);
  return done == kDone ? reportLosses(loaded->losses) : done;
}

}  // namespace

void addVoxelize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "voxelize", "Write a moving triangle mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<Options>();
  command
      ->add_option("MODEL", options->model,
                   "The solid: " + formats::readableTriangleMeshExtensions())
      ->required();
  command->add_option("-m,--motion", options->motion, "The motion: a JSON file (docs/motion.md)")
      ->required();
  options->series.addTo(*command);
  addFrameTimes(*command, options->series.times, "", kFramesByMotion);
  command->footer(
      "Example:\n  t4d voxelize bolt.obj --motion screw-in.json --voxel-size 0.25 -o bolt-frames\n"
      "  t4d voxelize bolt.obj --motion screw-in.json --voxel-size 0.25 --frames 60 --mask -o "
      "bolt-masks");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
