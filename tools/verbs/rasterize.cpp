#include "tools/verbs/rasterize.h"

#include <nlohmann/json.hpp>

#include "convert/frame_files.h"
#include "convert/frame_slices.h"
#include "platform/replaceable.h"
#include "t4d/check.h"
#include "tools/verbs/json_text.h"
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

std::string jsonOf(const GridFramesReport& report) {
  const voxel4d::VoxelSeries& series = report.written.series;
  return jsonText({{"frames", series.frames},
                   {"triangles", nullptr},
                   {"time_begin", report.written.time.begin},
                   {"time_end", report.written.time.end},
                   {"bytes", series.bytes},
                   {"manifest", report.manifest.string()},
                   {"light", false},
                   {"distance", 0},
                   {"max_speed", nullptr},
                   {"clamped", nullptr},
                   {"color_range", nullptr},
                   {"quantization_error", nullptr}});
}

}  // namespace t4d::verbs
