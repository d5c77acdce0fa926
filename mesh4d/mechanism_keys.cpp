#include "mesh4d/mechanism_keys.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include <fmt/format.h>

#include "model/degrees.h"

namespace t4d::mesh4d {
namespace {

using model::Point3;

constexpr double kHalfTurn = 180;

class PosedKeys : public model::VertexKeys {
 public:
  PosedKeys(const model::Mechanism& mechanism, const LinkSolid& solid,
            std::shared_ptr<const std::vector<double>> times)
      : mechanism_(mechanism), solid_(solid), times_(std::move(times)) {}

  std::uint64_t count() const override { return times_->size(); }
  double time(std::uint64_t key) const override { return (*times_)[key]; }
  std::optional<model::Affine3x4> pose(std::uint64_t key) const override {
    return (mechanism_.at(solid_.link, time(key)) * solid_.place).matrix();
  }
  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    const model::Affine3x4 matrix = *pose(key);
    for (std::size_t i = 0; i < into.size(); ++i) {
      into[i] = model::posed(matrix, solid_.mesh->vertices[i]);
    }
    return {};
  }

 private:
  const model::Mechanism& mechanism_;
  LinkSolid solid_;
  std::shared_ptr<const std::vector<double>> times_;
};

/// The data that bounds the deviation of a solid.
struct Extent {
  std::vector<Point3> corners;         // of its box, in the world at rest
  std::vector<Eigen::Vector3d> edges;  // in its own coordinates, the longest first
};

Extent extentOf(const LinkSolid& solid) {
  Extent extent;
  const model::Bounds3 bounds = model::boundsOf(*solid.mesh);
  constexpr int kCorners = 8;
  for (int i = 0; i < kCorners; ++i) {
    const Point3 corner((i & 1) != 0 ? bounds.max.x() : bounds.min.x(),
                        (i & 2) != 0 ? bounds.max.y() : bounds.min.y(),
                        (i & 4) != 0 ? bounds.max.z() : bounds.min.z());
    extent.corners.push_back(solid.place(corner));
  }
  for (const model::Triangle& triangle : solid.mesh->triangles) {
    for (int k = 0; k < 3; ++k) {
      // Each edge of a closed mesh is in two triangles, in opposite directions.
      const std::uint32_t from = triangle[k];
      const std::uint32_t to = triangle[(k + 1) % 3];
      if (from < to) {
        extent.edges.emplace_back(solid.mesh->vertices[to] - solid.mesh->vertices[from]);
      }
    }
  }
  std::ranges::sort(extent.edges, std::greater(), &Eigen::Vector3d::squaredNorm);
  return extent;
}

/// The worst of some steps.
struct Worst {
  double degrees = 0;
  double path = 0;   // of vertices off their chords
  double edges = 0;  // what the section between the layers adds
};

class Stepper {
 public:
  Stepper(const model::Mechanism& mechanism, std::span<const LinkSolid> solids,
          const StepRule& rule, PrismSplit split, std::optional<std::uint64_t> most)
      : mechanism_(mechanism), solids_(solids), rule_(rule), givenMost_(most) {
    edgeFactor_ = split == PrismSplit::Fourteen ? model::kEdgeFactorOf14 : model::kEdgeFactorOf3;
    for (const LinkSolid& solid : solids) extents_.push_back(extentOf(solid));
    bounds_.resize(solids.size());
  }

  /// Layers of these solids at the same times.
  Result<std::vector<double>> layersOf(std::span<const std::size_t> which,
                                       const model::TimeSpan& span) {
    std::set<double> knots = {span.begin, span.end};
    for (const std::size_t i : which) {
      const auto more = mechanism_.knots(solids_[i].link);
      knots.insert(more.begin(), more.end());
    }
    most_ = givenMost_.value_or(kMostMechanismSteps + knots.size());
    std::vector<double> times = {span.begin};
    for (auto knot = std::next(knots.begin()); knot != knots.end(); ++knot) {
      if (auto divided = divide(which, {times.back(), *knot}, times); !divided) {
        return divided.error();
      }
    }
    return times;
  }

  double boundOf(std::size_t solid) const { return bounds_[solid]; }

 private:
  /// Adds the ends of the steps between two knots.
  Result<void> divide(std::span<const std::size_t> which, const model::TimeSpan& span,
                      std::vector<double>& times) {
    double turn = 0;
    for (const std::size_t i : which) {
      turn = std::max(turn, turnBound(mechanism_, solids_[i].link, span));
    }
    double steps = std::max(1.0, std::ceil(turn / kHalfTurn));
    if (const auto* fixed = std::get_if<StepsPerSegment>(&rule_)) {
      steps = std::max(steps, static_cast<double>(fixed->steps));
    }
    steps = std::max(steps, leastSteps(which, span));
    const auto before = static_cast<double>(times.size() - 1);
    while (true) {
      if (!(before + steps <= static_cast<double>(most_))) return tooMany(before + steps);
      const auto count = static_cast<std::uint64_t>(steps);
      std::vector<double> bounds(solids_.size(), 0);
      const double share = shareOf(worstOf(which, span, count, bounds));
      if (share >= 1) {
        for (const std::size_t i : which) bounds_[i] = std::max(bounds_[i], bounds[i]);
        break;
      }
      // Bounds of longer steps are coarser, so the number grows in small leaps.
      steps = std::clamp(std::ceil(steps / share), steps + 1, 2 * steps);
    }
    const auto count = static_cast<std::uint64_t>(steps);
    for (std::uint64_t i = 1; i <= count; ++i) {
      const double time = model::dividedTime(span, i, count);
      if (time > times.back()) times.push_back(time);
    }
    return {};
  }

  /// A number that is never too large, so that steps need not grow up to it, nor beyond what is
  /// allowed: bounds of whole steps are no smaller than those of instants in them.
  double leastSteps(std::span<const std::size_t> which, const model::TimeSpan& span) const {
    const auto* deviation = std::get_if<MaxDeviation>(&rule_);
    if (deviation == nullptr) return 1;
    constexpr std::uint64_t kInstants = 8;
    constexpr double kRounding = 1e-6;
    double largest = 0;
    for (std::uint64_t i = 0; i < kInstants; ++i) {
      const double time = model::dividedTime(span, 2 * i + 1, 2 * kInstants);
      for (const std::size_t solid : which) {
        for (const Point3& corner : extents_[solid].corners) {
          largest = std::max(
              largest, accelerationBound(mechanism_, solids_[solid].link, corner, {time, time}));
        }
      }
    }
    const double duration = span.end - span.begin;
    const double steps = duration * std::sqrt(largest / 8 / deviation->length);
    return std::max(1.0, std::floor(steps * (1 - kRounding)));
  }

  /// The factor by which steps must become shorter; 1 or more if they may keep their length.
  double shareOf(const Worst& worst) const {
    constexpr double kRounding = 1e-9;
    if (const auto* volume = std::get_if<MinVolumeRatio>(&rule_)) {
      const double allowed = std::acos(2 * volume->ratio - 1) * model::kDegreesPerRadian;
      return worst.degrees <= allowed * (1 + kRounding) ? 1 : allowed / worst.degrees;
    }
    const auto* deviation = std::get_if<MaxDeviation>(&rule_);
    if (deviation == nullptr || worst.path + worst.edges <= deviation->length) return 1;
    // path x^2 + edges x = length
    const double length = deviation->length;
    const double root = std::sqrt(worst.edges * worst.edges + 4 * worst.path * length);
    return std::min(2 * length / (worst.edges + root), 1 - kRounding);
  }

  Worst worstOf(std::span<const std::size_t> which, const model::TimeSpan& span,
                std::uint64_t count, std::vector<double>& bounds) const {
    Worst worst;
    for (const std::size_t solid : which) {
      double before = span.begin;
      Eigen::Matrix3d from = rotationAt(solid, before);
      for (std::uint64_t i = 1; i <= count; ++i) {
        const double time = model::dividedTime(span, i, count);
        const Eigen::Matrix3d to = rotationAt(solid, time);
        const Worst one = stepOf(solid, {before, time}, from, to);
        worst.degrees = std::max(worst.degrees, one.degrees);
        worst.path = std::max(worst.path, one.path);
        worst.edges = std::max(worst.edges, one.edges);
        bounds[solid] = std::max(bounds[solid], one.path + one.edges);
        before = time;
        from = to;
      }
    }
    return worst;
  }

  Eigen::Matrix3d rotationAt(std::size_t solid, double time) const {
    return (mechanism_.at(solids_[solid].link, time) * solids_[solid].place).rotation;
  }

  Worst stepOf(std::size_t solid, const model::TimeSpan& step, const Eigen::Matrix3d& from,
               const Eigen::Matrix3d& to) const {
    Worst worst;
    const Eigen::Matrix3d change = to - from;
    // |change|^2 = 8 sin^2(angle / 2), to full precision at small angles.
    const double sine = std::min(1.0, change.norm() / std::sqrt(8.0));
    worst.degrees = 2 * std::asin(sine) * model::kDegreesPerRadian;
    const double duration = step.end - step.begin;
    for (const Point3& corner : extents_[solid].corners) {
      const double acceleration = accelerationBound(mechanism_, solids_[solid].link, corner, step);
      worst.path = std::max(worst.path, duration * duration * acceleration / 8);
    }
    // Where nothing turns, rotations are the same bits.
    if (change.isZero(0)) return worst;
    double longest = 0;
    for (const Eigen::Vector3d& edge : extents_[solid].edges) {
      // Neither this one nor a shorter one can change by more.
      if (4 * sine * sine * edge.squaredNorm() <= longest) break;
      longest = std::max(longest, (change * edge).squaredNorm());
    }
    worst.edges = edgeFactor_ / 2 * std::sqrt(longest);
    return worst;
  }

  Error tooMany(double steps) const {
    return invalid(fmt::format("the mechanism needs {:.4g} steps or more, at most {} are possible; "
                               "allow larger steps, or shorten the motion",
                               steps, most_),
                   {}, Remedy::StepRule);
  }

  const model::Mechanism& mechanism_;
  std::span<const LinkSolid> solids_;
  const StepRule& rule_;
  std::optional<std::uint64_t> givenMost_;
  std::uint64_t most_ = 0;
  double edgeFactor_ = 0;
  std::vector<Extent> extents_;
  std::vector<double> bounds_;
};

}  // namespace

Result<std::vector<LinkKeys>> mechanismKeys(const model::Mechanism& mechanism,
                                            std::span<const LinkSolid> solids, const StepRule& rule,
                                            PrismSplit split, bool common,
                                            std::optional<std::uint64_t> most) {
  if (auto good = checkRule(rule); !good) return good.error();
  const auto span = mechanism.span();
  if (!span) return invalid("nothing moves: give a body a motion", {}, Remedy::Motion);
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (mechanism.moves(solids[i].link)) moving.push_back(i);
  }
  Stepper stepper(mechanism, solids, rule, split, most);
  using Times = std::shared_ptr<const std::vector<double>>;
  std::vector<Times> times(solids.size(), std::make_shared<const std::vector<double>>(
                                              std::vector<double>{span->begin, span->end}));
  const std::size_t together = common ? moving.size() : 1;
  for (std::size_t first = 0; first < moving.size(); first += together) {
    const auto which = std::span(moving).subspan(first, together);
    auto layers = stepper.layersOf(which, *span);
    if (!layers) return layers.error();
    const auto shared = std::make_shared<const std::vector<double>>(std::move(*layers));
    for (const std::size_t i : which) times[i] = shared;
  }
  std::vector<LinkKeys> all;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    all.push_back(
        {std::make_unique<PosedKeys>(mechanism, solids[i], times[i]), stepper.boundOf(i)});
  }
  return all;
}

}  // namespace t4d::mesh4d
