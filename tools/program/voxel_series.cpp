#include "tools/program/voxel_series.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/verbs/lost_parts.h"
#include "t4d/verbs/weave_names.h"
#include "tools/program/console.h"
#include "tools/program/frame_options.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {
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
  static const std::vector<std::string> names(verbs::kCapStyleNames.begin(),
                                              verbs::kCapStyleNames.end());
  return names;
}

bool isVoxelCaps(const std::string& name) { return verbs::capStyleOf(name).has_value(); }

voxel4d::CapStyle voxelCapStyle(const std::string& name) {
  return verbs::capStyleOf(name).value_or(voxel4d::CapStyle::Flat);
}

void addBetween(CLI::App& command, std::optional<std::string>& between, const std::string& prefix) {
  command
      .add_option("--between", between,
                  prefix +
                      "Surface between frames of masks or labels: by distances from it, or at "
                      "the midpoint, as published")
      ->check(CLI::IsMember(
          std::vector<std::string>(verbs::kBetweenNames.begin(), verbs::kBetweenNames.end())))
      ->default_str(std::string(verbs::nameOfBetween(voxel4d::Between::Distance)));
}

voxel4d::Between betweenOf(const std::optional<std::string>& name) {
  return verbs::betweenOf(name.value_or("")).value_or(voxel4d::Between::Distance);
}

void LostPartsOptions::addTo(CLI::App& command) {
  command.add_flag("--fail-on-lost-parts", fails,
                   "Exit with 1 if a part moves by its own width or more between two frames");
}

int LostPartsOptions::exitCode(const voxel4d::LostParts& parts, int done) const {
  return fails && parts.count > 0 ? kFailed : done;
}

void VoxelSeriesOptions::addTo(CLI::App& command) {
  command.add_option("--voxel-size", voxelSize, "Voxel edge length, in length units")
      ->required()
      ->check(numberAboveZero());
  command.add_option("-o,--output", folder, "Output folder, for frame_0000.vdb, ...")
      ->required()
      ->check(someName());
  command.add_flag("--mask", mask, "Write masks of inside points instead of level sets");
  lostParts.addTo(command);
  part.addTo(command, "Write only part K of N of the frames, into the same folder");
  command.add_flag("--json", json, "Print the result as JSON");
}

void noticeEmptyFrames(const voxel4d::VoxelSeries& written) {
  if (written.emptyFrames == 0) return;
  printNotices(
      {fmt::format("{} of {} frames have no point inside; smaller voxels may find the solid",
                   written.emptyFrames, written.frames)});
}

int writeVoxelSeries(const VoxelSeriesOptions& options, const std::vector<double>& times,
                     const voxel4d::SolidAtTime& solid, const std::string& where,
                     nlohmann::ordered_json first, nlohmann::ordered_json identity) {
  if (const auto done = options.part.settle(times.size(), "frames")) return *done;
  const model::PartRange own = options.part.chosen().of(times.size());
  const auto begin = std::chrono::steady_clock::now();
  Result<voxel4d::VoxelSeries> written;
  {
    ProgressBar bar("voxelising", own.size(), "frames");
    written = voxel4d::writeVoxelFrames(solid, times,
                                        {options.voxelSize, options.mask, options.part.chosen()},
                                        options.folder, bar.callback());
  }
  if (!written) {
    Error error = written.error();
    // The library knows the solid, but not its file.
    if (error.where.empty()) error.where = where;
    return report(error);
  }

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    auto& result = first;
    result["frames"] = written->frames;
    result["time_begin"] = times[own.begin];
    result["time_end"] = times[own.end - 1];
    result["inside_points"] = written->insidePoints;
    result["empty_frames"] = written->emptyFrames;
    result["most_active_voxels"] = written->mostActiveVoxels;
    result["seconds"] = seconds;
    result["peak_bytes"] = peakBytes();
    result["bytes"] = written->bytes;
    result["parts_lost"] = verbs::jsonOf(written->partsLost);
    if (options.part.isGiven()) {
      identity["frames"] = times.size();
      result["part"] = options.part.json(std::move(identity));
    }
    printJson(result);
  } else {
    print("{}: {} of {} from time {} to {}\n", options.folder, counted(written->frames, "frame"),
          options.mask ? "inside points" : "level sets", times[own.begin], times[own.end - 1]);
    print("  {} inside, at most {} in a frame\n", counted(written->insidePoints, "point"),
          counted(written->mostActiveVoxels, "active voxel"));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(written->bytes), seconds,
          sizeText(peakBytes()));
  }
  noticeEmptyFrames(*written);
  std::vector<std::string> notices;
  verbs::noticeLostParts(written->partsLost, notices);
  printNotices(notices);
  return options.lostParts.exitCode(written->partsLost, kDone);
}

}  // namespace t4d::tools
