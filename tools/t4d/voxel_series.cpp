#include "tools/t4d/voxel_series.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/amount_text.h"
#include "platform/stopwatch.h"
#include "tools/t4d/console.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/lost_parts.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/weave_names.h"

namespace t4d::tools {
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

void addFrameTimes(CLI::App& command, voxel4d::FrameTimes& times, const std::string& prefix,
                   const std::string& otherwise) {
  command
      .add_option(kFramesOption, times.count, prefix + "Number of evenly spaced frames" + otherwise)
      ->check(wholeNumber(2, voxel4d::kMaxFrames));
  command
      .add_option("--frame-time", times.step,
                  prefix + "Time between frames; --frames then limits their number")
      ->check(numberAboveZero());
}

const std::vector<std::string>& voxelCaps() {
  static const std::vector<std::string> names(kCapStyleNames.begin(), kCapStyleNames.end());
  return names;
}

bool isVoxelCaps(const std::string& name) { return capStyleOf(name).has_value(); }

voxel4d::CapStyle voxelCapStyle(const std::string& name) {
  return capStyleOf(name).value_or(voxel4d::CapStyle::Flat);
}

void addBetween(CLI::App& command, std::optional<std::string>& between, const std::string& prefix) {
  command
      .add_option("--between", between,
                  prefix +
                      "Surface between frames of masks or labels: by distances from it, or at "
                      "the midpoint, as published")
      ->check(CLI::IsMember(std::vector<std::string>(kBetweenNames.begin(), kBetweenNames.end())))
      ->default_str(std::string(nameOfBetween(voxel4d::Between::Distance)));
}

voxel4d::Between chosenBetween(const std::optional<std::string>& name) {
  return betweenOf(name.value_or("")).value_or(voxel4d::Between::Distance);
}

void LostPartsOptions::addTo(CLI::App& command) {
  command.add_flag("--fail-on-lost-parts", fails,
                   "Exit with 1 if a part moves by its own width or more between two frames");
}

int LostPartsOptions::exitCode(const voxel4d::LostParts& parts, int done) const {
  return fails && parts.count > 0 ? kFailed : done;
}

void VoxelSeriesArguments::addTo(CLI::App& command) {
  command.add_option("--voxel-size", write.voxelSize, "Voxel edge length, in length units")
      ->required()
      ->check(numberAboveZero());
  command.add_option("-o,--output", write.folder, "Output folder, for frame_0000.vdb, ...")
      ->required()
      ->check(someName());
  command.add_flag("--mask", write.mask, "Write masks of inside points instead of level sets");
  lostParts.addTo(command);
  part.addTo(command, "Write only part K of N of the frames, into the same folder");
}

VoxelSeriesOptions VoxelSeriesArguments::at(std::vector<double> frameTimes,
                                            std::string name) const {
  VoxelSeriesOptions options = write;
  options.times = std::move(frameTimes);
  options.part = part.chosen();
  options.name = std::move(name);
  return options;
}

int reportVoxelSeries(const VoxelSeriesArguments& options, std::size_t frames,
                      const VoxelSeriesReport& written, nlohmann::ordered_json json,
                      nlohmann::ordered_json identity) {
  const voxel4d::VoxelSeries& series = written.series;
  if (options.json) {
    if (options.part.isGiven()) {
      identity["frames"] = frames;
      json = options.part.reportOf(std::move(json), std::move(identity));
    }
    printJson(json);
  } else {
    print("{}: {} of {} from time {} to {}\n", options.write.folder,
          counted(series.frames, "frame"), options.write.mask ? "inside points" : "level sets",
          written.time.begin, written.time.end);
    print("  {} inside, at most {} in a frame\n", counted(series.insidePoints, "point"),
          counted(series.mostActiveVoxels, "active voxel"));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(series.bytes), written.seconds,
          sizeText(peakBytes()));
  }
  printNotices(written.notices);
  return options.lostParts.exitCode(series.partsLost, kDone);
}

}  // namespace t4d::tools
