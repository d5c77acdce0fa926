#include "tools/verbs/voxel_series.h"

#include <fmt/format.h>

#include "model/amount_text.h"
#include "platform/stopwatch.h"
#include "tools/verbs/lost_parts.h"
#include "tools/verbs/members.h"

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

void describe(Members& members, const VoxelSeriesReport& report) {
  const voxel4d::VoxelSeries& series = report.series;
  members("frames", series.frames, "Number of frames, that is, of grids written.")
      .atLeast(1)
      .joined(Joined::Added);
  members("time_begin", report.time.begin, "Time of the first frame, in time units.")
      .joined(Joined::First);
  members("time_end", report.time.end, "Time of the last frame, in time units.")
      .joined(Joined::Last);
  members("inside_points", series.insidePoints,
          "Lattice points inside the solid, in all frames together.")
      .joined(Joined::Added);
  members("empty_frames", series.emptyFrames, "Frames without a point inside.")
      .joined(Joined::Added);
  members("most_active_voxels", series.mostActiveVoxels,
          "Largest number of active voxels in a frame.")
      .joined(Joined::Most);
  addCosts(members, report.seconds);
  members("bytes", series.bytes, "Size of all files together, in bytes.").joined(Joined::Added);
  addLostParts(members, series.partsLost);
}

}  // namespace t4d::verbs
