#include "tools/program/voxel_series.h"

#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/program/console.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {

void addFrameTimes(CLI::App& command, voxel4d::FrameTimes& times, const std::string& prefix) {
  command
      .add_option("--frames", times.count,
                  prefix + "So many frames, evenly from first to last time")
      ->check(wholeNumber(2, voxel4d::kMaxFrames));
  command
      .add_option(
          "--frame-time", times.step,
          prefix + "Frames so far apart, from the first time on; with --frames the first so many")
      ->check(numberAboveZero());
}

void VoxelSeriesOptions::addTo(CLI::App& command) {
  command
      .add_option("--voxel-size", voxelSize,
                  "Edge of a voxel, in length units; lattice points are its multiples")
      ->required()
      ->check(numberAboveZero());
  auto* when = command.add_option_group("frames", "Which times; one of these, or both");
  addFrameTimes(*when, times);
  when->require_option(1, 2);
  command.add_option("-o,--output", folder, "The folder to write frame_0000.vdb, ... into")
      ->required()
      ->check(someName());
  command.add_flag("--mask", mask,
                   "Write which lattice points are strictly inside, instead of level sets");
  addThreadsOption(command, threads);
  command.add_flag("--json", json, "Print what was made as JSON");
}

int writeVoxelSeries(const VoxelSeriesOptions& options, const model::TimeSpan& span,
                     const voxel4d::SolidAtTime& solid, const std::string& where) {
  const auto begin = std::chrono::steady_clock::now();
  const ThreadLimit limit(options.threads);
  const auto times = voxel4d::frameTimes(span, options.times);
  if (!times) return report(times.error());
  Result<voxel4d::VoxelSeries> written;
  {
    ProgressBar bar("voxelising");
    written = voxel4d::writeVoxelFrames(solid, *times, {options.voxelSize, options.mask},
                                        options.folder, bar.callback());
  }
  if (!written) {
    Error error = written.error();
    // What is wrong with a solid is known without its file.
    if (error.where.empty()) error.where = where;
    return report(error);
  }

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    printJson({{"frames", written->frames},
               {"time_begin", times->front()},
               {"time_end", times->back()},
               {"inside_points", written->insidePoints},
               {"most_active_voxels", written->mostActiveVoxels},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()},
               {"bytes", written->bytes}});
  } else {
    fmt::print("{}: {} of {} from time {} to {}\n", options.folder,
               counted(written->frames, "frame"), options.mask ? "inside points" : "level sets",
               times->front(), times->back());
    fmt::print("  {} inside, at most {} in a frame\n", counted(written->insidePoints, "point"),
               counted(written->mostActiveVoxels, "active voxel"));
    fmt::print("  {}, {:.2f} s, peak memory {}\n", sizeText(written->bytes), seconds,
               sizeText(peakBytes()));
  }
  return kDone;
}

}  // namespace t4d::tools
