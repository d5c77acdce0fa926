#include "tools/verbs/voxel_series.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/amount_text.h"
#include "platform/stopwatch.h"
#include "tools/verbs/json_text.h"
#include "tools/verbs/lost_parts.h"

namespace t4d::verbs {

Result<VoxelSeriesReport> writeVoxelSeries(const voxel4d::SolidAtTime& solid,
                                           const VoxelSeriesOptions& options, Observer& observer) {
  const std::vector<double>& times = options.times;
  if (times.empty() || options.part.count > times.size()) {
    return fail(ErrorCode::Options, fmt::format("there are {} frames, too few for {} parts",
                                                times.size(), options.part.count));
  }
  const platform::Stopwatch stopwatch;
  const model::PartRange own = options.part.of(times.size());
  const auto stage = observer.stage("voxelising", own.size(), "frames");
  auto written =
      voxel4d::writeVoxelFrames(solid, times, {options.voxelSize, options.mask, options.part},
                                options.folder, stage->callback(), options.beforeRenaming);
  if (!written) {
    Error error = written.error();
    if (error.where.empty()) error.where = options.name;
    return error;
  }
  VoxelSeriesReport report{.series = std::move(*written),
                           .time = {times[own.begin], times[own.end - 1]}};
  report.seconds = stopwatch.seconds();
  noticeEmptyFrames(report.series, report.notices);
  noticeLostParts(report.series.partsLost, report.notices);
  return report;
}

void noticeEmptyFrames(const voxel4d::VoxelSeries& series, std::vector<std::string>& notices) {
  if (series.emptyFrames == 0) return;
  notices.push_back(
      fmt::format("{} of {} frames have no point inside; smaller voxels may find the solid",
                  series.emptyFrames, series.frames));
}

std::string jsonOf(const VoxelSeriesReport& report, std::uint64_t peakBytes) {
  const voxel4d::VoxelSeries& series = report.series;
  return jsonText({{"frames", series.frames},
                   {"time_begin", report.time.begin},
                   {"time_end", report.time.end},
                   {"inside_points", series.insidePoints},
                   {"empty_frames", series.emptyFrames},
                   {"most_active_voxels", series.mostActiveVoxels},
                   {"seconds", report.seconds},
                   {"peak_bytes", peakBytes},
                   {"bytes", series.bytes},
                   {"parts_lost", jsonOf(series.partsLost)}});
}

}  // namespace t4d::verbs
