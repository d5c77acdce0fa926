#include "measure/seen_part.h"

#include <algorithm>
#include <cmath>

namespace t4d::measure {
namespace {

using model::Point3;
using model::Point4;

/// A point of the part as it is seen, and how far along the view the other is from there.
struct Above {
  Point3 at;
  double height;

  friend Above between(const Above& a, const Above& b, double fraction) {
    return {a.at + fraction * (b.at - a.at), a.height + fraction * (b.height - a.height)};
  }
};

/// A side of a tetrahedron as it is seen: 0 on it, 1 at the corner across from it.
struct Side {
  Point3 normal;
  double offset;

  double depth(const Point3& point) const { return normal.dot(point) - offset; }
};

std::array<Side, 4> sidesOf(const std::array<Point3, 4>& corners) {
  std::array<Side, 4> sides;
  for (int k = 0; k < 4; ++k) {
    const Point3& from = corners[(k + 1) % 4];
    const Point3 normal = (corners[(k + 2) % 4] - from).cross(corners[(k + 3) % 4] - from);
    const Point3 scaled = normal / normal.dot(corners[k] - from);
    sides[k] = {scaled, scaled.dot(from)};
  }
  return sides;
}

/// Whether all of a piece that lies within the sides from `number` on is within a distance. What
/// lies on both sides of one is divided there.
bool isNearWithin(const std::array<Above, 4>& piece, const std::array<Side, 4>& sides,
                  std::size_t number, double distance) {
  constexpr double kRounding = 1e-9;
  if (std::ranges::all_of(piece,
                          [&](const Above& one) { return std::abs(one.height) <= distance; })) {
    return true;
  }
  if (number == sides.size()) return false;
  std::array<double, 4> depths{};
  for (int i = 0; i < 4; ++i) depths[i] = sides[number].depth(piece[i].at);
  const auto out = std::ranges::min_element(depths) - depths.begin();
  const auto in = std::ranges::max_element(depths) - depths.begin();
  if (depths[in] <= kRounding) return true;
  if (depths[out] >= -kRounding) return isNearWithin(piece, sides, number + 1, distance);
  const Above cut = between(piece[in], piece[out], depths[in] / (depths[in] - depths[out]));
  for (const auto end : {in, out}) {
    auto half = piece;
    half[end] = cut;
    if (!isNearWithin(half, sides, number, distance)) return false;
  }
  return true;
}

}  // namespace

Range::Range(const Point3& direction, std::span<const Point3> points)
    : least(direction.dot(points[0])), most(least) {
  for (const Point3& point : points.subspan(1)) {
    const double height = direction.dot(point);
    least = std::min(least, height);
    most = std::max(most, height);
  }
}

bool Range::isApartFrom(const Range& other) const {
  constexpr double kRounding = 1e-10;
  if (!(most > least)) return false;
  const double rounding = kRounding * (most - least + other.most - other.least);
  return other.most <= least + rounding || other.least >= most - rounding;
}

SeenPart::SeenPart(const View& view, const std::array<Point4, 4>& corners)
    : view_(view),
      corners_(corners),
      seen_({view(corners[0]), view(corners[1]), view(corners[2]), view(corners[3])}) {
  for (int k = 0; k < 3; ++k) directions_[k] = Point3::Unit(k);
  for (int k = 0; k < 4; ++k) {
    const Point3& from = seen_[(k + 1) % 4];
    directions_[3 + k] = (seen_[(k + 2) % 4] - from).cross(seen_[(k + 3) % 4] - from);
  }
  for (std::size_t k = 0; k < directions_.size(); ++k) ranges_[k] = {directions_[k], seen_};
}

bool SeenPart::isApartFrom(const std::array<Point3, 3>& triangle) const {
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    if (ranges_[k].isApartFrom(Range(directions_[k], triangle))) return true;
  }
  const auto areApart = [&](const Point3& direction) {
    return Range(direction, seen_).isApartFrom(Range(direction, triangle));
  };
  const auto side = [&](int i) -> Point3 { return triangle[(i + 1) % 3] - triangle[i]; };
  if (areApart(side(0).cross(side(1)))) return true;
  for (int i = 0; i < 3; ++i) {
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        if (areApart(side(i).cross(seen_[b] - seen_[a]))) return true;
      }
    }
  }
  return false;
}

bool SeenPart::isNear(const SpaceTimeTetrahedron& other, double distance) const {
  const std::array<Point3, 4> seen = {view_(other.corners[0]), view_(other.corners[1]),
                                      view_(other.corners[2]), view_(other.corners[3])};
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    if (ranges_[k].isApartFrom(Range(directions_[k], seen))) return true;
  }
  const double cosine = other.normal.head<3>().dot(view_.direction());
  std::array<Above, 4> piece;
  for (int k = 0; k < 4; ++k) {
    piece[k] = {seen_[k], other.normal.dot(corners_[k] - other.corners[0]) / cosine};
  }
  const auto sides = sidesOf(seen);
  const auto isSound = [](const Side& side) { return side.normal.allFinite(); };
  return std::ranges::all_of(sides, isSound) && isNearWithin(piece, sides, 0, distance);
}

}  // namespace t4d::measure
