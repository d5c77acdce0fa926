#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "model/number.h"
#include "t4d/frames.h"

namespace t4d::voxel4d {
namespace {

constexpr std::string_view kAxes = "xyzt";

std::string textOf(const IndexRange& range) {
  const auto number = [](const std::optional<std::int64_t>& one) {
    return one ? std::to_string(*one) : std::string();
  };
  return number(range.begin) + ":" + number(range.end);
}

/// One end of a range; false if it is neither empty nor a number.
bool readEnd(std::string_view text, std::optional<std::int64_t>& end) {
  if (text.empty()) return true;
  end = model::numberIn<std::int64_t>(text);
  return end.has_value();
}

Result<IndexRange> parseRange(std::string_view text, char axis) {
  IndexRange range;
  const auto colon = text.find(':');
  if (colon == std::string_view::npos || !readEnd(text.substr(0, colon), range.begin) ||
      !readEnd(text.substr(colon + 1), range.end)) {
    return invalid(fmt::format(
        "'{}' is not a range of whole numbers along {}, as 10:20, 10: or :", text, axis));
  }
  // A begin that is left out is 0, or below every end.
  if (range.begin && range.end && *range.begin >= *range.end) {
    return invalid(fmt::format("{} along {} is empty: a range begins below its end", text, axis));
  }
  return range;
}

}  // namespace

Result<Region> parseRegion(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (words.size() != 3 && words.size() != 4) {
    return invalid(
        fmt::format("'{}' has {} ranges; expected those along x, y and z, and of frames if not "
                    "all are used, as 0:64,10:20,:,0:8",
                    text, words.size()));
  }
  Region region;
  for (std::size_t i = 0; i < words.size(); ++i) {
    auto range = parseRange(words[i], kAxes[i]);
    if (!range) return range.error();
    (i < 3 ? region.space[i] : region.time) = *range;
  }
  return region;
}

Result<Extent> extentOf(const IndexRange& range, char axis, std::uint64_t count,
                        const std::string& where) {
  const bool frames = axis == 't';
  const auto size = static_cast<std::int64_t>(count);
  const std::int64_t begin = range.begin.value_or(0);
  const std::int64_t end = range.end.value_or(size);
  if (begin < 0 || begin >= end || end > size) {
    return invalid(fmt::format("the region has {} along {}, where there are {} {}, counted from 0",
                               textOf(range), axis, count, frames ? "frames" : "samples"),
                   where);
  }
  if (frames && end - begin < 2) {
    return invalid(fmt::format("the region has {} along t: one frame only; a 4D mesh needs two or "
                               "more",
                               textOf(range)),
                   where);
  }
  return Extent{static_cast<std::uint64_t>(begin), static_cast<std::uint64_t>(end - begin)};
}

}  // namespace t4d::voxel4d
