#include "edit/slab_windows.h"

#include <algorithm>

#include <fmt/format.h>

namespace t4d::edit {
namespace {

Result<std::uint64_t> cellsOf(const model::Source& source, std::size_t index) {
  if (const auto count = source.cellCount(index)) return *count;
  const auto slab = source.slab(index);
  if (!slab) return slab.error();
  return (*slab)->connectivity->cells.size();
}

}  // namespace

Result<std::vector<Window>> windowsOf(const model::Source& source,
                                      std::optional<std::uint64_t> slabs, std::uint64_t mostCells) {
  std::vector<Window> windows;
  std::uint64_t inWindow = 0;
  bool wasFlat = true;
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    const auto cells = cellsOf(source, i);
    if (!cells) return cells.error();
    const model::TimeSpan time = source.timeSpan(i);
    const bool isFlat = time.begin == time.end;
    const bool isFull = windows.empty() || (slabs ? i - windows.back().begin >= *slabs
                                                  : inWindow + *cells > mostCells);
    if (isFull || isFlat || wasFlat) {
      windows.push_back({i, i});
      inWindow = 0;
    }
    windows.back().end = i + 1;
    inWindow += *cells;
    wasFlat = isFlat;
  }
  return windows;
}

Result<std::vector<Window>> windowsOfPart(const std::vector<Window>& windows,
                                          const model::Part& part) {
  if (part.number < 1 || part.number > part.count || windows.size() < part.count) {
    return fail(ErrorCode::Options,
                fmt::format("part {} of {} was asked for, and the mesh has {} windows: take "
                            "fewer parts, or smaller windows",
                            part.number, part.count, windows.size()));
  }
  // A part begins with the window in which the slabs of the parts before it are done, and leaves a
  // window to each part after it.
  const auto firstOf = [&](std::uint64_t parts) {
    const std::size_t slabs = windows.back().end * parts / part.count;
    const auto found = std::ranges::lower_bound(windows, slabs, {}, &Window::begin);
    return std::clamp<std::size_t>(found - windows.begin(), parts,
                                   windows.size() - (part.count - parts));
  };
  const auto begin = static_cast<std::ptrdiff_t>(firstOf(part.number - 1));
  const auto end = static_cast<std::ptrdiff_t>(firstOf(part.number));
  return std::vector<Window>(windows.begin() + begin, windows.begin() + end);
}

}  // namespace t4d::edit
