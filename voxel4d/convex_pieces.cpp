#include "voxel4d/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace t4d::voxel4d {
namespace {

using Eigen::Vector2d;

double crossOf(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The distance of a point from the line through two others, positive on its left.
double leftOf(const Vector2d& from, const Vector2d& to, const Vector2d& point) {
  const double length = (to - from).norm();
  return length > 0 ? crossOf(to - from, point - from) / length : 0;
}

/// The parts to the left and the right of a line; what is within `tolerance` of it belongs to both.
std::pair<ConvexPolygon, ConvexPolygon> split(const ConvexPolygon& polygon,
                                              const PlaneSegment& line, double tolerance) {
  std::pair<ConvexPolygon, ConvexPolygon> parts;
  const auto sideOf = [&](const Vector2d& point) {
    const double distance = leftOf(line.from, line.to, point);
    return std::abs(distance) <= tolerance ? 0.0 : distance;
  };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& here = polygon[i];
    const Vector2d& next = polygon[(i + 1) % polygon.size()];
    const double a = sideOf(here);
    const double b = sideOf(next);
    if (a >= 0) parts.first.push_back(here);
    if (a <= 0) parts.second.push_back(here);
    if ((a > 0 && b < 0) || (a < 0 && b > 0)) {
      const Vector2d between = here + a / (a - b) * (next - here);
      parts.first.push_back(between);
      parts.second.push_back(between);
    }
  }
  return parts;
}

std::vector<PlaneSegment> cutsOf(const ConvexPolygon& polygon,
                                 const std::vector<PlaneSegment>& segments, double tolerance) {
  std::vector<PlaneSegment> cuts;
  for (const PlaneSegment& segment : segments) {
    const auto inside = within(polygon, segment, tolerance);
    if (inside && isCut(polygon, *inside, tolerance)) cuts.push_back(*inside);
  }
  return cuts;
}

}  // namespace

std::optional<PlaneSegment> within(const ConvexPolygon& polygon, const PlaneSegment& segment,
                                   double tolerance) {
  constexpr double kTouches = 8;  // tolerances
  double begin = 0;
  double end = 1;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& from = polygon[i];
    const Vector2d& to = polygon[(i + 1) % polygon.size()];
    const double a = leftOf(from, to, segment.from) + tolerance;
    const double b = leftOf(from, to, segment.to) + tolerance;
    if (a < 0 && b < 0) return std::nullopt;
    if (a < 0) begin = std::max(begin, a / (a - b));
    if (b < 0) end = std::min(end, a / (a - b));
  }
  const Vector2d along = segment.to - segment.from;
  if (!((end - begin) * along.norm() > kTouches * tolerance)) return std::nullopt;
  return PlaneSegment{segment.from + begin * along, segment.from + end * along};
}

bool isCut(const ConvexPolygon& polygon, const PlaneSegment& segment, double tolerance) {
  const Vector2d middle = (segment.from + segment.to) / 2;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (leftOf(polygon[i], polygon[(i + 1) % polygon.size()], middle) <= tolerance) return false;
  }
  return true;
}

std::vector<ConvexPolygon> cutAlong(ConvexPolygon polygon,
                                    const std::vector<PlaneSegment>& segments, double tolerance,
                                    std::size_t most) {
  struct Piece {
    ConvexPolygon polygon;
    std::vector<PlaneSegment> cuts;
  };
  std::vector<ConvexPolygon> pieces;
  std::vector<Piece> waiting;
  const auto add = [&](ConvexPolygon part, const std::vector<PlaneSegment>& among) {
    auto cuts = cutsOf(part, among, tolerance);
    if (cuts.empty()) {
      pieces.push_back(std::move(part));
    } else {
      waiting.push_back({std::move(part), std::move(cuts)});
    }
  };
  add(std::move(polygon), segments);
  while (!waiting.empty()) {
    Piece piece = std::move(waiting.back());
    waiting.pop_back();
    if (piece.cuts.empty() || pieces.size() + waiting.size() >= most) {
      pieces.push_back(std::move(piece.polygon));
      continue;
    }
    // The middle one of consecutive segments, such as around a hole, leaves as many on either side.
    const auto middle = piece.cuts.begin() + static_cast<std::ptrdiff_t>(piece.cuts.size() / 2);
    auto [left, right] = split(piece.polygon, *middle, tolerance);
    piece.cuts.erase(middle);
    if (left.size() < 3 || right.size() < 3) {
      waiting.push_back(std::move(piece));
      continue;
    }
    add(std::move(left), piece.cuts);
    add(std::move(right), piece.cuts);
  }
  return pieces;
}

}  // namespace t4d::voxel4d
