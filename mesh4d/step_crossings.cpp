#include "mesh4d/step_crossings.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>

#include "model/parallel.h"

namespace t4d::mesh4d {
namespace {

using CrossingKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using ExactPoint = CrossingKernel::Point_3;
using SweptBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
using model::Point3;
using model::Point4;
using model::Triangle;

/// Times nearer to each other than this, as a fraction of the step, are one.
constexpr double kResolution = 1e-7;

/// The ends of the step, and the roots of the 15 cubics of a pair.
class Times {
 public:
  void add(double time) { times_[count_++] = time; }
  std::span<double> all() { return {times_.data(), count_}; }

 private:
  std::array<double, 2 + 3 * 15> times_;
  std::size_t count_ = 0;
};

/// A cubic on [0, 1] as its Bernstein coefficients.
struct Cubic {
  std::array<double, 4> b;
  double rounding;  ///< of a coefficient, at most

  enum class Sign : std::uint8_t { Negative, Positive, Zero, Mixed };
  /// The sign on the open interval, as far as the coefficients tell. Those within rounding of zero
  /// count as zero.
  Sign sign() const {
    bool positive = false;
    bool negative = false;
    for (const double c : b) {
      positive |= c > rounding;
      negative |= c < -rounding;
    }
    if (positive && negative) return Sign::Mixed;
    if (positive) return Sign::Positive;
    return negative ? Sign::Negative : Sign::Zero;
  }

  double at(double s) const {
    const double r = 1 - s;
    return r * r * r * b[0] + 3 * r * r * s * b[1] + 3 * r * s * s * b[2] + s * s * s * b[3];
  }

  /// Adds the roots in [0, 1] where the sign changes by more than rounding.
  void addRoots(Times& roots) const {
    if (sign() != Sign::Mixed) return;
    // Between the roots of the derivative, up to a factor (1 - s)^2 d0 + 2 s (1 - s) d1 + s^2 d2,
    // the cubic is monotonic.
    const double d0 = b[1] - b[0];
    const double d1 = b[2] - b[1];
    const double d2 = b[3] - b[2];
    const double a = d0 - 2 * d1 + d2;
    const double h = d1 - d0;
    std::array<double, 4> ends = {0, 1, 1, 1};
    int count = 1;
    const double discriminant = h * h - a * d0;
    if (discriminant > 0) {
      const double q = -(h + std::copysign(std::sqrt(discriminant), h));
      std::array<double, 2> extremes = {q != 0 ? d0 / q : 2, a != 0 ? q / a : 2};
      std::ranges::sort(extremes);
      for (const double s : extremes) {
        if (s > 0 && s < 1) ends[count++] = s;
      }
    }
    for (int i = 0; i < count; ++i) {
      double low = ends[i];
      double high = i + 1 < count ? ends[i + 1] : 1;
      const bool below = at(low) < 0;
      if (below == (at(high) < 0)) continue;
      while (high - low > kResolution / 16) {
        const double middle = (low + high) / 2;
        ((at(middle) < 0) == below ? low : high) = middle;
      }
      roots.add((low + high) / 2);
    }
  }
};

double det(const Point3& a, const Point3& b, const Point3& c) { return a.dot(b.cross(c)); }

/// Two triangles in motion, relative to a corner of the first. Common corners come first in both.
class MovingPair {
 public:
  MovingPair(const model::TriangleMesh& mesh, std::span<const Point3> start,
             std::span<const Point3> end, std::uint32_t first, std::uint32_t second)
      : origins_{start[mesh.triangles[first][0]], end[mesh.triangles[first][0]]} {
    Triangle a = mesh.triangles[first];
    Triangle b = mesh.triangles[second];
    for (int i = 0; i < 3; ++i) {
      const auto found = std::find(b.begin() + shared_, b.end(), a[i]);
      if (found == b.end()) continue;
      std::swap(a[i], a[shared_]);
      std::swap(*found, b[shared_]);
      ++shared_;
    }
    double largest = 0;
    for (int i = 0; i < 6; ++i) {
      const std::uint32_t vertex = i < 3 ? a[i] : b[i - 3];
      from_[i] = start[vertex] - origins_[0];
      to_[i] = end[vertex] - origins_[1];
      largest = std::max({largest, from_[i].cwiseAbs().maxCoeff(), to_[i].cwiseAbs().maxCoeff()});
    }
    // The rounding of a sum of some dozen products of three differences, each at most twice the
    // largest.
    constexpr double kOfProduct = 1e-14;
    rounding_ = kOfProduct * largest * largest * largest;
  }

  /// When they meet first, as far as is seen; nothing if they do not.
  std::optional<double> meetAt() {
    if (shared_ == 3) return 0;
    if (shared_ == 2) return swingAt();
    if (stayApart()) return std::nullopt;
    times_.add(0);
    times_.add(1);
    // If one stays on one side of the other's plane, they have at most the common corner in common.
    if (staysAside(0, 3) || staysAside(3, 0)) return std::nullopt;
    if (shared_ == 0) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 3; k < 6; ++k) {
          volume(i, (i + 1) % 3, k, 3 + (k + 1) % 3).addRoots(times_);
        }
      }
    } else {
      volume(1, 2, 4, 5).addRoots(times_);
    }
    const auto times = times_.all();
    std::ranges::sort(times);
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      if (times[i + 1] - times[i] < kResolution) continue;
      const double middle = (times[i] + times[i + 1]) / 2;
      if (meet(middle)) return middle;
    }
    return std::nullopt;
  }

  /// About where they meet: the middle of where the sides of each pass through the other, or, if
  /// they lie in one plane, of their corners.
  Point3 placeAt(double s) const {
    Point3 sum = Point3::Zero();
    int count = 0;
    for (const int side : {0, 3}) {
      const Point3 a = at(3 - side, s);
      const Point3 u = at(4 - side, s) - a;
      const Point3 v = at(5 - side, s) - a;
      for (int i = 0; i < 3; ++i) {
        const Point3 p = at(side + i, s);
        const Point3 w = at(side + (i + 1) % 3, s) - p;
        // p + t w = a + x u + y v
        const double whole = det(u, v, w);
        const double t = det(u, v, a - p) / whole;
        const double x = det(p - a, v, w) / whole;
        const double y = det(u, p - a, w) / whole;
        if (!(t >= 0 && t <= 1 && x >= 0 && y >= 0 && x + y <= 1)) continue;
        sum += p + t * w;
        ++count;
      }
    }
    if (count == 0) {
      for (int i = 0; i < 6; ++i) sum += at(i, s);
      count = 6;
    }
    return sum / count + (1 - s) * origins_[0] + s * origins_[1];
  }

 private:
  Point3 at(int i, double s) const { return (1 - s) * from_[i] + s * to_[i]; }

  ExactPoint exactAt(int i, double s) const {
    const Point3 p = at(i, s);
    return {p.x(), p.y(), p.z()};
  }

  /// Six times the volume of the tetrahedron of four corners.
  Cubic volume(int i, int j, int k, int l) const {
    const Point3 u0 = from_[j] - from_[i];
    const Point3 v0 = from_[k] - from_[i];
    const Point3 w0 = from_[l] - from_[i];
    const Point3 u1 = to_[j] - to_[i];
    const Point3 v1 = to_[k] - to_[i];
    const Point3 w1 = to_[l] - to_[i];
    const Point3 n00 = u0.cross(v0);
    const Point3 n01 = u0.cross(v1) + u1.cross(v0);
    const Point3 n11 = u1.cross(v1);
    return {{n00.dot(w0), (n01.dot(w0) + n00.dot(w1)) / 3, (n11.dot(w0) + n01.dot(w1)) / 3,
             n11.dot(w1)},
            rounding_};
  }

  /// Whether a plane with a fixed direction is between them all the time, through the common corner
  /// if there is one: that across the line between their middles, half way. All corners move along
  /// straight lines, so that both ends decide.
  bool stayApart() const {
    const Point3 direction =
        from_[1] + from_[2] + to_[1] + to_[2] - from_[4] - from_[5] - to_[4] - to_[5] +
        (shared_ == 0 ? from_[0] + to_[0] - from_[3] - to_[3] : Point3(Point3::Zero()));
    for (const auto& places : {from_, to_}) {
      double lowest = std::numeric_limits<double>::infinity();
      double highest = -lowest;
      for (int i = shared_; i < 3; ++i) {
        lowest = std::min(lowest, direction.dot(places[i]));
        highest = std::max(highest, direction.dot(places[3 + i]));
      }
      if (shared_ == 1) {
        const double common = direction.dot(places[0]);
        if (!(lowest > common && common > highest)) return false;
      }
      if (!(lowest > highest)) return false;
    }
    return true;
  }

  /// Whether the triangle at `other` stays strictly on one side of the plane of that at `base`, but
  /// for the common corner. If not, adds when its corners pass through that plane.
  bool staysAside(int base, int other) {
    using Sign = Cubic::Sign;
    std::array<Cubic, 3> heights;
    const int first = shared_;  // 0 or 1
    bool aside = true;
    Sign common = Sign::Zero;
    for (int i = first; i < 3; ++i) {
      heights[i] = volume(base, base + 1, base + 2, other + i);
      const Sign sign = heights[i].sign();
      if (i == first) common = sign;
      aside &= sign == common && (sign == Sign::Positive || sign == Sign::Negative);
    }
    if (aside) return true;
    for (int i = first; i < 3; ++i) {
      heights[i].addRoots(times_);
    }
    return false;
  }

  bool meet(double s) const {
    std::array<ExactPoint, 6> p;
    for (int i = 0; i < 6; ++i) p[i] = exactAt(i, s);
    if (CGAL::collinear(p[0], p[1], p[2]) || CGAL::collinear(p[3], p[4], p[5])) return false;
    const CrossingKernel::Triangle_3 a(p[0], p[1], p[2]);
    const CrossingKernel::Triangle_3 b(p[3], p[4], p[5]);
    if (shared_ == 0) return CGAL::do_intersect(a, b);
    return CGAL::do_intersect(a, CrossingKernel::Segment_3(p[4], p[5])) ||
           CGAL::do_intersect(b, CrossingKernel::Segment_3(p[1], p[2]));
  }

  /// The time when one of two triangles with a common side swings through the other.
  std::optional<double> swingAt() {
    const Cubic cubic = volume(0, 1, 2, 5);
    const auto onOneSide = [&](double s) {
      const Point3 axis = at(1, s) - at(0, s);
      return axis.cross(at(2, s) - at(0, s)).dot(axis.cross(at(5, s) - at(0, s))) > 0;
    };
    cubic.addRoots(times_);
    for (const double root : times_.all()) {
      const double before = root - kResolution;
      const double after = root + kResolution;
      if (before < 0 || after > 1 || !onOneSide(before) || !onOneSide(after)) continue;
      const auto sideAt = [&](double s) {
        return CGAL::orientation(exactAt(0, s), exactAt(1, s), exactAt(2, s), exactAt(5, s));
      };
      if (sideAt(before) * sideAt(after) == CGAL::NEGATIVE) return root;
    }
    return std::nullopt;
  }

  std::array<Point3, 2> origins_;
  std::array<Point3, 6> from_;  // at the start: the first triangle, the second
  std::array<Point3, 6> to_;
  int shared_ = 0;
  double rounding_ = 0;
  Times times_;
};

Point3 meanOf(std::span<const Point3> places) {
  Point3 sum = Point3::Zero();
  for (const Point3& place : places) sum += place;
  return sum / static_cast<double>(places.size());
}

/// The boxes of all triangles on the way, in a frame that follows the mean of the vertices.
std::vector<SweptBox> sweptBoxes(const model::TriangleMesh& mesh, std::span<const Point3> from,
                                 std::span<const Point3> to) {
  const Point3 shift = meanOf(to) - meanOf(from);
  double largest = 0;
  for (const auto& places : {from, to}) {
    for (const Point3& place : places) largest = std::max(largest, place.cwiseAbs().maxCoeff());
  }
  constexpr double kRounding = 1e-15;
  const Point3 margin = Point3::Constant(4 * kRounding * largest);
  std::vector<SweptBox> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    model::Bounds3 bounds;
    for (const std::uint32_t corner : mesh.triangles[i]) {
      bounds.add(from[corner]);
      bounds.add(to[corner] - shift);
    }
    const Point3 low = bounds.min - margin;
    const Point3 high = bounds.max + margin;
    boxes.emplace_back(CGAL::Bbox_3(low.x(), low.y(), low.z(), high.x(), high.y(), high.z()), i);
  }
  return boxes;
}

/// The number of parts of the step to search one after the other, so that the boxes stay small: in
/// each the vertices move, on average and relative to their mean, by about two edges.
int partsOf(const model::TriangleMesh& mesh, std::span<const Point3> from,
            std::span<const Point3> to) {
  const Point3 shift = meanOf(to) - meanOf(from);
  double motion = 0;
  for (std::size_t i = 0; i < from.size(); ++i) motion += (to[i] - from[i] - shift).norm();
  double length = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    length += (from[b] - from[a]).norm() + (from[c] - from[b]).norm() + (to[b] - to[a]).norm() +
              (to[c] - to[b]).norm();
  }
  const double edges = (motion / static_cast<double>(from.size())) /
                       (length / static_cast<double>(4 * mesh.triangles.size()));
  constexpr double kMost = 64;
  return static_cast<int>(std::ceil(std::min(std::max(edges / 2, 1.0), kMost)));
}

/// With fewer boxes than this, all pairs are compared. Found by trial.
constexpr std::ptrdiff_t kCutoff = 200;

struct EnoughPairs {};

using TrianglePair = std::array<std::uint32_t, 2>;

/// Pairs that meet, and the first of them; of those at one time, that of the smallest numbers.
struct Meetings {
  std::vector<TrianglePair> pairs;
  double earliest = 2;
  TrianglePair triangles = {0, 0};
  Point3 place = Point3::Zero();

  bool precedes(const Meetings& other) const {
    return std::tie(earliest, triangles) < std::tie(other.earliest, other.triangles);
  }
};

/// A part of a step, as fractions of it, with the places at both of its ends.
struct StepPart {
  double begin;
  double length;
  std::vector<Point3> from;
  std::vector<Point3> to;
};

/// Tests pairs of triangles on all threads, many at a time.
class PairTester {
 public:
  PairTester(const model::TriangleMesh& mesh, const StepPart& part, Meetings& found)
      : mesh_(mesh), part_(part), found_(found) {
    waiting_.reserve(kBatch);
  }

  void add(const TrianglePair& pair) {
    waiting_.push_back(pair);
    if (waiting_.size() == kBatch) finish();
  }

  /// Tests the pairs that wait. The result does not depend on their order.
  void finish() {
    const std::size_t pieces = (waiting_.size() + kPiece - 1) / kPiece;
    std::vector<Meetings> ofPieces(pieces);
    model::forEach(pieces, [&](std::size_t piece) {
      const std::size_t end = std::min(waiting_.size(), (piece + 1) * kPiece);
      for (std::size_t i = piece * kPiece; i < end; ++i) test(waiting_[i], ofPieces[piece]);
    });
    for (const Meetings& piece : ofPieces) {
      found_.pairs.insert(found_.pairs.end(), piece.pairs.begin(), piece.pairs.end());
      if (!piece.precedes(found_)) continue;
      found_.earliest = piece.earliest;
      found_.triangles = piece.triangles;
      found_.place = piece.place;
    }
    waiting_.clear();
  }

 private:
  void test(const TrianglePair& triangles, Meetings& found) const {
    MovingPair pair(mesh_, part_.from, part_.to, triangles[0], triangles[1]);
    const auto s = pair.meetAt();
    if (!s) return;
    found.pairs.push_back(triangles);
    const double at = part_.begin + *s * part_.length;
    if (std::tie(at, triangles) >= std::tie(found.earliest, found.triangles)) return;
    found.earliest = at;
    found.triangles = triangles;
    found.place = pair.placeAt(*s);
  }

  // A pair takes about a microsecond; a batch is half a megabyte.
  static constexpr std::size_t kBatch = 1 << 16;
  static constexpr std::size_t kPiece = 1 << 10;

  const model::TriangleMesh& mesh_;
  const StepPart& part_;
  Meetings& found_;
  std::vector<TrianglePair> waiting_;
};

}  // namespace

Result<std::optional<StepCrossing>> crossingOf(const model::TriangleMesh& mesh,
                                               const model::Slab& step) try {
  std::vector<Point3> start;
  std::vector<Point3> end;
  for (const Point4& vertex : step.lowerLayer()) start.emplace_back(vertex.head<3>());
  for (const Point4& vertex : step.upperLayer()) end.emplace_back(vertex.head<3>());
  StepCrossing found;
  found.time = {step.timeBegin, step.timeEnd};
  Meetings meetings;
  std::uint64_t looked = 0;
  const int parts = partsOf(mesh, start, end);
  for (int number = 0; number < parts && found.complete; ++number) {
    // Parts overlap, so that nothing is lost where they meet.
    constexpr double kOverlap = 1e-3;
    StepPart part;
    part.begin = std::max(0.0, (number - kOverlap) / parts);
    part.length = std::min(1.0, (number + 1 + kOverlap) / parts) - part.begin;
    const auto placesAt = [&](double s) {
      std::vector<Point3> places;
      for (std::size_t i = 0; i < start.size(); ++i) {
        places.emplace_back((1 - s) * start[i] + s * end[i]);
      }
      return places;
    };
    part.from = placesAt(part.begin);
    part.to = placesAt(part.begin + part.length);
    const auto boxes = sweptBoxes(mesh, part.from, part.to);
    // Sorting pointers is faster.
    std::vector<const SweptBox*> sorted;
    for (const SweptBox& box : boxes) sorted.push_back(&box);
    PairTester tester(mesh, part, meetings);
    const auto look = [&](const SweptBox* one, const SweptBox* other) {
      if (++looked > kMostSweptPairs) throw EnoughPairs();
      const auto [a, b] = std::minmax({one->info(), other->info()});
      tester.add({a, b});
    };
    try {
      CGAL::box_self_intersection_d(sorted.begin(), sorted.end(), look, kCutoff);
    } catch (const EnoughPairs&) {
      found.complete = false;
    }
    tester.finish();
  }
  auto& pairs = meetings.pairs;
  if (pairs.empty() && found.complete) return std::nullopt;
  std::ranges::sort(pairs);
  found.pairs = std::unique(pairs.begin(), pairs.end()) - pairs.begin();
  found.triangles = meetings.triangles;
  found.place = meetings.place;
  if (found.pairs > 0) {
    found.at = step.timeBegin + meetings.earliest * (step.timeEnd - step.timeBegin);
  }
  return found;
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed,
              fmt::format("the search for self-crossings between keys failed: {}", error.what()));
}

}  // namespace t4d::mesh4d
