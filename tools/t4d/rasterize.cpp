#include "tools/t4d/rasterize.h"

#include <fmt/format.h>

#include "convert/frame_files.h"
#include "convert/frame_slices.h"
#include "platform/replaceable.h"
#include "t4d/check.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/frames.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {
Result<VoxelSeriesReport> rasterize(const Input& input, const VoxelSeriesOptions& options,
                                    Observer& observer) {
  if (const std::string notice = noticeOfOrigin(input); !notice.empty()) observer.note(notice);
  VoxelSeriesOptions how = options;
  if (how.name.empty()) how.name = input.name;
  return writeVoxelSeries([&](double time) { return measure::solidAt(input.bodies, time); }, how,
                          observer);
}

std::string noticeOfOrigin(const Input& input) {
  if (originOf(input.metadata).isZero(0)) return {};
  return "the grids have the coordinates of the file, whose origin was moved; .vdb has no place to "
         "say so";
}

Result<GridFramesReport> writeGridFrames(const Input& input, const VoxelSeriesOptions& options,
                                         Observer& observer) {
  if (auto checked = convert::checkFrameTimes(input.bodies, options.times); !checked) {
    return inInput(checked.error(), input);
  }
  const auto path = std::filesystem::path(options.folder) / convert::FrameNames().manifest;
  const std::string manifestName = path.filename().string();
  if (auto good = platform::checkReplaceable(options.folder, {&manifestName, 1}); !good) {
    return good.error();
  }
  const formats::Metadata& metadata = input.metadata;
  convert::FramesManifest manifest;
  manifest.space = {metadata.lengthUnit, metadata.timeUnit, metadata.up};
  manifest.origin = originOf(metadata);
  const auto solidAt = [&](double time) {
    auto solid = measure::solidAt(input.bodies, time);
    if (solid) {
      manifest.frames.push_back({.file = {}, .time = time, .volume = signedVolume(*solid)});
    }
    return solid;
  };
  VoxelSeriesOptions how = options;
  how.beforeRenaming = [&] { return convert::removeOldManifest(path); };
  auto written = writeVoxelSeries(solidAt, how, observer);
  if (!written) return inInput(written.error(), input);
  for (std::size_t i = 0; i < manifest.frames.size(); ++i) {
    manifest.frames[i].file = written->series.files[i].name;
    manifest.frames[i].bytes = written->series.files[i].bytes;
  }
  if (auto done = convert::writeManifest(path, manifest); !done) return done.error();
  return GridFramesReport{std::move(*written), path};
}

void describe(Members& members, const GridFramesReport& report) {
  FramesReport frames;
  frames.ofGrids = true;
  frames.manifest = report.manifest;
  frames.firstTime = report.written.time.begin;
  frames.lastTime = report.written.time.end;
  frames.written.frames = report.written.series.frames;
  frames.written.bytes = report.written.series.bytes;
  describe(members, frames);
}

namespace {

struct RasterizeArguments {
  std::string input;
  InputOptions only;
  VoxelSeriesArguments series;
};

int run(const RasterizeArguments& options) {
  auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  voxel4d::FrameTimes when = options.series.times;
  if (!when.count && !when.step) {
    when.count = kDefaultFrames;
    noticeDefaultFrames();
  }
  const auto times = voxel4d::frameTimes(model::timeSpanOf(input->bodies), when);
  if (!times) return report(times.error());
  if (const auto done = options.series.part.settle(times->size(), "frames")) {
    if (const auto notice = noticeOfOrigin(*input); !notice.empty()) printNotices({notice});
    return *done;
  }
  ConsoleObserver observer;
  const auto written = rasterize(*input, options.series.at(*times, input->name), observer);
  if (!written) return report(written.error());
  return reportVoxelSeries(options.series, times->size(), *written, Members::valueOf(*written),
                           identityOf(*input));
}

}  // namespace

void addRasterize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("rasterize",
                                     "Write slices of a 4D mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<RasterizeArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  options->series.addTo(*command);
  addJsonOption<VoxelSeriesReport>(
      *command, options->series.json,
      "What was made of a 4D mesh: a time series of OpenVDB grids, a file each.");
  addFrameTimes(*command, options->series.times, "",
                fmt::format(" (default: {}, or set by --frame-time)", kDefaultFrames));
  command->footer(
      "Example:\n  t4d rasterize bolt.t4d --voxel-size 0.25 --frames 60 -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
