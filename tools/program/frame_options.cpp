#include "tools/program/frame_options.h"

#include <fmt/format.h>

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
  which->require_option(0, 1);
}

std::vector<double> FrameOptions::of(const model::TimeSpan& span, std::uint64_t most) const {
  if (!times.empty()) return *timesOf(times, most);
  if (!count) noticeDefaultFrames();
  return model::evenTimes(span, count.value_or(kDefaultFrames));
}

}  // namespace t4d::tools
