#include "model/slab_groups.h"

#include <algorithm>

namespace t4d::model {

const std::vector<SlabGroup>& slabGroupsOf(const Source& source) {
  static const std::vector<SlabGroup> none;
  const auto* grouped = dynamic_cast<const GroupedSource*>(&source);
  return grouped == nullptr ? none : grouped->groups();
}

std::size_t firstSlabEndingAfter(const Source& source, double time, bool orThen) {
  const auto isBefore = [&](double end) { return orThen ? end < time : end <= time; };
  std::size_t low = 0;
  std::size_t high = source.slabCount();
  if (const auto& groups = slabGroupsOf(source); !groups.empty()) {
    const auto group = std::ranges::partition_point(
        groups, isBefore, [](const SlabGroup& each) { return each.time.end; });
    if (group == groups.end()) return high;
    low = group->first;
    high = group->end - 1;  // the last ends late enough
  }
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (isBefore(source.timeSpan(middle).end)) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

double endOfSlab(const Source& source, std::size_t index) {
  const auto& groups = slabGroupsOf(source);
  const auto group = std::ranges::lower_bound(groups, index + 1, {}, &SlabGroup::end);
  if (group != groups.end() && group->end == index + 1) return group->time.end;
  return source.timeSpan(index).end;
}

}  // namespace t4d::model
