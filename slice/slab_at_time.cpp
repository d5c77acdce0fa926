#include "slice/slab_at_time.h"

#include <fmt/format.h>

#include "model/slab_groups.h"

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
  const std::size_t slab = model::firstSlabEndingAfter(source, at.time, at.atEnd);
  if (slab < source.slabCount() && source.timeSpan(slab).begin <= at.time) at.slab = slab;
  return at;
}

}  // namespace t4d::slice
