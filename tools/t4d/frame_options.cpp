#include "tools/t4d/frame_options.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "formats/input_file.h"
#include "tools/t4d/console.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/speed_curve.h"
#include "tools/t4d/text_table.h"

namespace t4d::tools {
namespace {

constexpr const char* kTimesGroup = "frames";

Result<std::vector<double>> readTimes(const std::string& path, std::uint64_t most) {
  const auto file = formats::readInputFile(path);
  if (!file) return file.error();
  TableLines lines(file->bytes);
  std::vector<double> times;
  std::size_t column = 0;
  bool first = true;
  while (const auto line = lines.next()) {
    const std::vector<std::string_view>& fields = line->fields;
    if (std::exchange(first, false) && !numberOf(fields.front())) {
      const auto named = std::ranges::find(fields, "time");
      if (named != fields.end()) column = static_cast<std::size_t>(named - fields.begin());
      continue;
    }
    const auto time = column < fields.size() ? numberOf(fields[column]) : std::nullopt;
    if (!time) {
      return invalid(
          column < fields.size()
              ? fmt::format("found '{}', expected a time", quotable(fields[column]))
              : fmt::format("has {} columns; the time is number {}", fields.size(), column + 1),
          file->atLine(line->number));
    }
    if (times.size() == most) {
      return invalid(fmt::format("has more than {} times", most), file->atLine(line->number));
    }
    times.push_back(*time);
  }
  if (times.empty()) return invalid("has no times", path);
  return times;
}

}  // namespace

void noticeDefaultFrames() {
  printNotices(
      {fmt::format("{} frames, evenly spaced; --frames changes their number", kDefaultFrames)});
}

void FrameOptions::addTo(CLI::App& command, std::uint64_t most, const std::string& usual) {
  auto* which = command.add_option_group(kTimesGroup, "Times of the frames (at most one of these)");
  which
      ->add_option(kFramesOption, count,
                   fmt::format("Number of evenly spaced frames (default: {})",
                               usual.empty() ? fmt::format("{}", kDefaultFrames) : usual))
      ->check(wholeNumber(1, most));
  which
      ->add_option("--times", times,
                   "N evenly spaced times from A to B, both included; or a list of times")
      ->check(timesUpTo(most));
  which
      ->add_option("--times-file", timesFile,
                   "Times of a file, one a line, in any order; of a table, its first column or "
                   "the one named time")
      ->check(someName());
  which->require_option(0, 1);
}

void FrameOptions::addAtFramesTo(CLI::App& command) {
  command.get_option_group(kTimesGroup)
      ->add_flag("--at-frames", atFrames,
                 "Times of the frames, or ends of steps, that the mesh was made of");
}

CLI::Option* FrameOptions::addSpeedTo(CLI::App& command) {
  command.get_option_group(kTimesGroup)
      ->add_option("--speed-file", speedFile,
                   "Times of a curve: a table of playback,time or playback,speed")
      ->check(someName());
  return command.add_option("--fps", framesPerSecond, "Frames per second")
      ->check(numberAboveZero())
      ->capture_default_str();
}

std::optional<std::string> FrameOptions::unevenOption() const {
  if (!timesFile.empty()) return "--times-file";
  if (!speedFile.empty()) return "--speed-file";
  // A:B:N are even, a list need not be.
  if (!times.empty() && times.find(':') == std::string::npos) return "--times";
  return std::nullopt;
}

Result<std::vector<double>> FrameOptions::of(const model::TimeSpan& span,
                                             std::uint64_t most) const {
  if (!timesFile.empty()) return readTimes(timesFile, most);
  if (!speedFile.empty()) return timesOfCurve(speedFile, span, framesPerSecond, most);
  if (!times.empty()) return *timesOf(times, most);
  if (!count) noticeDefaultFrames();
  return model::evenTimes(span, count.value_or(kDefaultFrames));
}

}  // namespace t4d::tools
