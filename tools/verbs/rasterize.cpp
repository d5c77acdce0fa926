#include "tools/verbs/rasterize.h"

#include "convert/frame_files.h"
#include "convert/frame_slices.h"
#include "platform/replaceable.h"
#include "t4d/check.h"
#include "tools/verbs/frames.h"
#include "tools/verbs/members.h"
#include "tools/verbs/origin.h"

namespace t4d::verbs {

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

}  // namespace t4d::verbs
