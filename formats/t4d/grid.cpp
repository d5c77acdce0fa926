#include <cmath>
#include <limits>

#include "t4d/file.h"

namespace t4d::formats {

double Grid::coordinate(int axis, std::int32_t number) const {
  const double along = step * number;
  return origin[axis] + along;
}

std::optional<std::int32_t> Grid::number(int axis, double coordinate) const {
  constexpr double kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  const double number = std::nearbyint((coordinate - origin[axis]) / step);
  if (!(number >= kLeast && number <= kMost)) return std::nullopt;
  return static_cast<std::int32_t>(number);
}

model::Point3 Grid::nearest(const model::Point3& point) const {
  model::Point3 nearest;
  for (int axis = 0; axis < 3; ++axis) {
    nearest[axis] = coordinate(axis, *number(axis, point[axis]));
  }
  return nearest;
}

Grid Grid::about(const model::Point3& point, double step) {
  constexpr double kNear = 1 << 30;
  Grid grid;
  grid.step = step;
  for (int axis = 0; axis < 3; ++axis) {
    const double number = std::nearbyint(point[axis] / step);
    if (std::abs(number) > kNear) grid.origin[axis] = step * number;
  }
  return grid;
}

}  // namespace t4d::formats
