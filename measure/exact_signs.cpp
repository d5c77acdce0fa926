#include "measure/exact_signs.h"

#include <array>
#include <cmath>

#include "model/exact_sum.h"

namespace t4d::measure {
namespace {

using model::Point3;
using Factor = model::ExactSum::Factor;

constexpr double kUnit = std::numeric_limits<double>::epsilon() / 2;  // of rounding
// Error bounds of the determinants computed in doubles, relative to the sum of the magnitudes of
// their terms.
constexpr double kBound2 = (3 + 16 * kUnit) * kUnit;
constexpr double kBound3 = (7 + 56 * kUnit) * kUnit;
// Below, products may have lost bits that are too small for a double.
constexpr double kSmall = 0x1p-800;

int exactOrientation(const Point2& a, const Point2& b, const Point2& c) {
  const auto across = Factor::difference(b.x(), a.x());
  const auto up = Factor::difference(b.y(), a.y());
  const auto otherAcross = Factor::difference(c.x(), a.x());
  const auto otherUp = Factor::difference(c.y(), a.y());
  model::ExactSum sum;
  sum.add(std::array{&across, &otherUp}, false);
  sum.add(std::array{&up, &otherAcross}, true);
  return sum.sign();
}

int exactOrientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  std::array<std::array<Factor, 3>, 3> rows;
  for (int i = 0; i < 3; ++i) {
    rows[0][i] = Factor::difference(b[i], a[i]);
    rows[1][i] = Factor::difference(c[i], a[i]);
    rows[2][i] = Factor::difference(d[i], a[i]);
  }
  model::ExactSum sum;
  model::addDeterminant(sum, rows);
  return sum.sign();
}

}  // namespace

int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (b.x() - a.x()) * (c.y() - a.y());
  const double right = (b.y() - a.y()) * (c.x() - a.x());
  const double det = left - right;
  const double magnitude = std::abs(left) + std::abs(right);
  if (magnitude > kSmall && std::abs(det) > kBound2 * magnitude) return det > 0 ? 1 : -1;
  return exactOrientation(a, b, c);
}

int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Point3 u = b - a;
  const Point3 v = c - a;
  const Point3 w = d - a;
  const double yz = v.y() * w.z();
  const double zy = v.z() * w.y();
  const double zx = v.z() * w.x();
  const double xz = v.x() * w.z();
  const double xy = v.x() * w.y();
  const double yx = v.y() * w.x();
  const double det = u.x() * (yz - zy) + u.y() * (zx - xz) + u.z() * (xy - yx);
  const double magnitude = std::abs(u.x()) * (std::abs(yz) + std::abs(zy)) +
                           std::abs(u.y()) * (std::abs(zx) + std::abs(xz)) +
                           std::abs(u.z()) * (std::abs(xy) + std::abs(yx));
  if (magnitude > kSmall && std::abs(det) > kBound3 * magnitude) return det > 0 ? 1 : -1;
  return exactOrientation(a, b, c, d);
}

int movedOrientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  int sign = orientation(a, b, c, d);
  // The normal of the plane, x first.
  for (int axis = 0; axis < 3 && sign == 0; ++axis) {
    sign = orientation(acrossAxis(a, axis), acrossAxis(b, axis), acrossAxis(c, axis));
  }
  return sign;
}

}  // namespace t4d::measure
