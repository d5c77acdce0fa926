#include "tools/t4d/time_window.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/t4d/option_checks.h"

namespace t4d::tools {
Result<model::TimeSpan> TimeWindow::spanIn(const Input& input) const {
  if (from && to && *from >= *to) {
    return fail(ErrorCode::Options, fmt::format("--from {} is not before --to {}", *from, *to));
  }
  const model::TimeSpan whole = model::timeSpanOf(input.bodies);
  model::TimeSpan span{from.value_or(whole.begin), to.value_or(whole.end)};
  for (double* time : {&span.begin, &span.end}) {
    for (const model::Body& body : input.bodies) {
      const auto meant = model::timeWithin(*body.source, *time);
      if (!meant || *meant == *time) continue;
      *time = *meant;
      break;
    }
  }
  if (span.begin >= whole.end || span.end <= whole.begin) {
    return invalid(
        fmt::format("nothing is left: the mesh lasts from time {} to {}", whole.begin, whole.end),
        input.name);
  }
  return model::TimeSpan{std::max(span.begin, whole.begin), std::min(span.end, whole.end)};
}

void keepThoseWithin(const model::TimeSpan& span, Input& input, std::vector<std::string>& notices) {
  std::erase_if(input.bodies, [&](const model::Body& body) {
    const model::TimeSpan times = model::timeSpanOf(*body.source);
    if (times.begin < span.end && times.end > span.begin) return false;
    notices.push_back(fmt::format("body '{}' exists only from {} to {}; it is left out", body.name,
                                  times.begin, times.end));
    return true;
  });
}

void TimeWindow::addTo(CLI::App& command) {
  command.add_option("--from", from, "Start time (default: start of the mesh)")
      ->type_name("TIME")
      ->check(finiteNumber());
  command.add_option("--to", to, "End time (default: end of the mesh)")
      ->type_name("TIME")
      ->check(finiteNumber());
}

}  // namespace t4d::tools
