#include "tools/program/frame_options.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "t4d/formats/input_file.h"
#include "tools/program/console.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {

void noticeDefaultFrames() {
  printNotices({fmt::format("{} frames, evenly spaced; --frames takes another number of them",
                            kDefaultFrames)});
}

void FrameOptions::addTo(CLI::App& command, std::uint64_t most) {
  auto* which = command.add_option_group("frames", "Times of the frames (at most one of these)");
  which
      ->add_option(kFramesOption, count,
                   fmt::format("Number of evenly spaced frames (default: {})", kDefaultFrames))
      ->check(wholeNumber(1, most));
  which->add_option("--times", times, "N evenly spaced times from A to B, both included")
      ->check(evenTimesUpTo(most));
  which
      ->add_option("--times-file", timesFile,
                   "Times of a file, one a line, in any order; of a table, its first column or "
                   "the one named time")
      ->check(someName());
  which->require_option(0, 1);
}

namespace {

constexpr std::size_t kMostQuoted = 40;  // bytes

std::vector<std::string_view> fieldsOf(std::string_view line) {
  constexpr std::string_view kSeparators = ",; \t\r";
  std::vector<std::string_view> fields;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
    if (line.empty()) return fields;
    const std::size_t end = std::min(line.find_first_of(kSeparators), line.size());
    fields.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

Result<std::vector<double>> readTimes(const std::string& path, std::uint64_t most) {
  const auto file = formats::readInputFile(path);
  if (!file) return pass(file.error());
  std::string_view rest = file->bytes;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  std::vector<double> times;
  std::size_t column = 0;
  bool first = true;
  for (std::uint64_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::vector<std::string_view> fields = fieldsOf(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (fields.empty() || fields.front().starts_with('#')) continue;
    if (std::exchange(first, false) && !numberOf(fields.front())) {
      const auto named = std::ranges::find(fields, "time");
      if (named != fields.end()) column = static_cast<std::size_t>(named - fields.begin());
      continue;
    }
    const auto time = column < fields.size() ? numberOf(fields[column]) : std::nullopt;
    if (!time) {
      return invalid(
          column < fields.size()
              ? fmt::format("found '{}', expected a time", fields[column].substr(0, kMostQuoted))
              : fmt::format("has {} columns; the time is number {}", fields.size(), column + 1),
          file->atLine(line));
    }
    if (times.size() == most) {
      return invalid(fmt::format("has more than {} times", most), file->atLine(line));
    }
    times.push_back(*time);
  }
  if (times.empty()) return invalid("has no times", path);
  return times;
}

}  // namespace

Result<std::vector<double>> FrameOptions::of(const model::TimeSpan& span,
                                             std::uint64_t most) const {
  if (!timesFile.empty()) return readTimes(timesFile, most);
  if (!times.empty()) return *timesOf(times, most);
  if (!count) noticeDefaultFrames();
  return model::evenTimes(span, count.value_or(kDefaultFrames));
}

}  // namespace t4d::tools
