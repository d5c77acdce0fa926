#include "tools/t4d/moved_bounds.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "model/limits.h"

namespace t4d::tools {

Result<bool> checkMovedBounds(const model::Bounds3& bounds, const model::TimeSpan& span,
                              const model::Transform& transform, const std::string& where) {
  model::Bounds3 moved;
  for (unsigned corner = 0; corner < 8; ++corner) {
    model::Point3 point;
    for (unsigned axis = 0; axis < 3; ++axis) {
      point[axis] = (corner >> axis & 1U) != 0 ? bounds.max[axis] : bounds.min[axis];
    }
    moved.add(model::posed(transform.space, point));
  }
  const double farthest =
      std::max(moved.max.cwiseAbs().maxCoeff(), moved.min.cwiseAbs().maxCoeff());
  const double narrowest = (moved.max - moved.min).minCoeff();
  constexpr double kMostWidths = 4e12;  // doubles are finer there than a thousandth of the width
  constexpr double kFewWidths = 1e3;
  const model::TimeSpan times{transform.time(span.begin), transform.time(span.end)};
  const double latest = std::max(std::abs(times.begin), std::abs(times.end));
  const double duration = times.end - times.begin;
  if (!(latest <= model::kLargestCoordinate)) {
    return invalid(fmt::format("would reach the time {:.3g}; the largest possible time is {}. "
                               "Scale or shift times less",
                               latest, model::kLargestCoordinate),
                   where);
  }
  if (span.end > span.begin && !(duration >= model::kSmallestExtent)) {
    return invalid(fmt::format("would last for {:.3g}; the shortest possible duration is {}. Scale "
                               "times less",
                               duration, model::kSmallestExtent),
                   where);
  }
  if ((bounds.max - bounds.min).minCoeff() > 0 && !(narrowest >= model::kSmallestExtent)) {
    return invalid(fmt::format("would be {:.3g} wide where it is narrowest; the smallest possible "
                               "width is {}. Scale it less",
                               narrowest, model::kSmallestExtent),
                   where);
  }
  if (!(farthest <= model::kLargestCoordinate)) {
    return invalid(
        fmt::format("would reach {:.3g} from the origin; the largest possible coordinate "
                    "is {}. Scale or move it less",
                    farthest, model::kLargestCoordinate),
        where);
  }
  if (farthest <= kMostWidths * narrowest) {
    return farthest > kFewWidths * narrowest || latest > kFewWidths * duration;
  }
  return invalid(fmt::format("would reach {:.3g} from the origin, and be {:.3g} wide where it is "
                             "narrowest: doubles are too coarse there to keep its shape. Move it "
                             "less, or scale all axes alike",
                             farthest, narrowest),
                 where);
}

}  // namespace t4d::tools
