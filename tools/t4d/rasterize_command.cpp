#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/voxel_series.h"
#include "tools/verbs/rasterize.h"

namespace t4d::tools {
namespace {

struct RasterizeArguments {
  std::string input;
  InputOptions only;
  VoxelSeriesOptions series;
};

int run(const RasterizeArguments& options) {
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  voxel4d::FrameTimes when = options.series.times;
  if (!when.count && !when.step) {
    when.count = kDefaultFrames;
    noticeDefaultFrames();
  }
  const auto times = voxel4d::frameTimes(model::timeSpanOf(input->bodies), when);
  if (!times) return report(times.error());
  if (const auto done = options.series.part.settle(times->size(), "frames")) {
    if (const auto notice = verbs::noticeOfOrigin(*input); !notice.empty()) printNotices({notice});
    return *done;
  }
  ConsoleObserver observer;
  const auto written = verbs::rasterize(*input, options.series.at(*times, input->name), observer);
  if (!written) return report(written.error());
  return reportVoxelSeries(options.series, times->size(), *written,
                           verbs::Members::valueOf(*written), verbs::identityOf(*input));
}

}  // namespace

void addRasterize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("rasterize",
                                     "Write slices of a 4D mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<RasterizeArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  options->series.addTo(*command);
  addJsonOption<verbs::VoxelSeriesReport>(
      *command, options->series.json,
      "What was made of a 4D mesh: a time series of OpenVDB grids, a file each.");
  addFrameTimes(*command, options->series.times, "",
                fmt::format(" (default: {}, or set by --frame-time)", kDefaultFrames));
  command->footer(
      "Example:\n  t4d rasterize bolt.t4d --voxel-size 0.25 --frames 60 -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
