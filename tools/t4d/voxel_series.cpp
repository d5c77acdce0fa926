#include "tools/t4d/voxel_series.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/t4d/console.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/option_checks.h"
#include "tools/verbs/weave_names.h"

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
}

verbs::VoxelSeriesOptions VoxelSeriesOptions::at(std::vector<double> frameTimes,
                                                 std::string name) const {
  return {std::move(frameTimes), voxelSize, mask, part.chosen(), folder, std::move(name), {}};
}

int reportVoxelSeries(const VoxelSeriesOptions& options, std::size_t frames,
                      const verbs::VoxelSeriesReport& written, nlohmann::ordered_json json,
                      nlohmann::ordered_json identity) {
  const voxel4d::VoxelSeries& series = written.series;
  if (options.json) {
    if (options.part.isGiven()) {
      identity["frames"] = frames;
      json = options.part.reportOf(std::move(json), std::move(identity));
    }
    printJson(json);
  } else {
    print("{}: {} of {} from time {} to {}\n", options.folder, counted(series.frames, "frame"),
          options.mask ? "inside points" : "level sets", written.time.begin, written.time.end);
    print("  {} inside, at most {} in a frame\n", counted(series.insidePoints, "point"),
          counted(series.mostActiveVoxels, "active voxel"));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(series.bytes), written.seconds,
          sizeText(peakBytes()));
  }
  printNotices(written.notices);
  return options.lostParts.exitCode(series.partsLost, kDone);
}

}  // namespace t4d::tools
