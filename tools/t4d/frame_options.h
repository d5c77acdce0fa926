#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::tools {

/// The number of frames of a verb that is given none.
inline constexpr std::uint64_t kDefaultFrames = 60;

/// The names of the option for the number of frames, the same in all verbs that have one.
inline constexpr const char* kFramesOption = "-n,--frames,--count";

/// Tells that there are kDefaultFrames frames because no number was given.
void noticeDefaultFrames();

/// Moments of a 4D mesh: `count` of them, evenly spaced over its whole time, `times`, or those of a
/// list or a curve in a file.
struct FrameOptions {
  std::optional<std::uint64_t> count;
  std::string times;
  std::string timesFile;
  std::string speedFile;
  double framesPerSecond = 24;
  bool atFrames = false;

  /// Adds `--frames`, `--times` and `--times-file`, of which one or none is given, each for up to
  /// `most` frames. `usual` says what is the default, if not kDefaultFrames.
  void addTo(CLI::App& command, std::uint64_t most, const std::string& usual = {});

  /// Adds `--at-frames` to these: then the times are those of frameTimesOf.
  void addAtFramesTo(CLI::App& command);

  /// Adds `--speed-file` to these, and `--fps`, which it returns.
  CLI::Option* addSpeedTo(CLI::App& command);

  /// The option that gives the frames times which need not be even, if one does.
  std::optional<std::string> unevenOption() const;

  /// The times of the frames, up to the same `most`; tells where their number is the default. Fails
  /// if the file has none, too many, or something else.
  Result<std::vector<double>> of(const model::TimeSpan& span, std::uint64_t most) const;
};

}  // namespace t4d::tools
