#include "t4d/measure/compare.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

struct Options {
  std::string input;
  std::string body;
  VoxelSeriesOptions series;
};

int run(const Options& options) {
  auto input = openBodies(options.input, options.body);
  if (!input) return report(input.error());
  return writeVoxelSeries(
      options.series, model::timeSpanOf(input->bodies),
      [&](double time) { return measure::solidAt(input->bodies, time); }, options.input);
}

}  // namespace

void addRasterize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("rasterize",
                                     "Write slices of a 4D mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<Options>();
  command->add_option("FILE", options->input, "The .t4d file")->required();
  addBodyOption(*command, options->body);
  options->series.addTo(*command);
  command->footer(
      "Example:\n  t4d rasterize bolt.t4d --voxel-size 0.25 --frames 60 -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
