#include "t4d/slice/slab_at_time.h"

#include <fmt/format.h>

namespace t4d::slice {

Result<SlabAtTime> slabAtTime(const model::Source& source, double given) {
  const auto meant = model::timeWithin(source, given);
  if (!meant) {
    if (source.slabCount() == 0) return invalid("the mesh has no slabs");
    const model::TimeSpan span = timeSpanOf(source);
    return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", given,
                               span.begin, span.end));
  }
  SlabAtTime at{*meant, *meant == timeSpanOf(source).end, {}};
  // The first slab that ends later or, at the very end, the first that ends there.
  std::size_t low = 0;
  std::size_t high = source.slabCount();
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    const double end = source.timeSpan(middle).end;
    if (at.atEnd ? end >= at.time : end > at.time) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  if (low < source.slabCount() && source.timeSpan(low).begin <= at.time) at.slab = low;
  return at;
}

}  // namespace t4d::slice
