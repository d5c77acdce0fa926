#include <algorithm>
#include <limits>

#include "t4d/mesh.h"

namespace t4d::model {

TimeSpan timeSpanOf(std::span<const Body> bodies) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  TimeSpan span{kInfinity, -kInfinity};
  for (const Body& body : bodies) {
    if (body.source->slabCount() == 0) continue;
    const TimeSpan one = timeSpanOf(*body.source);
    span = {std::min(span.begin, one.begin), std::max(span.end, one.end)};
  }
  return span.begin <= span.end ? span : TimeSpan{};
}

}  // namespace t4d::model
