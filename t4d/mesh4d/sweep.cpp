#include "t4d/mesh4d/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "t4d/model/limits.h"
#include "t4d/model/surface_check.h"

namespace t4d::mesh4d {
namespace {

using model::Point3;
using model::Point4;
using model::Pose;
using model::Slab;
using model::TriangleMesh;

/// With more triangles, the indices of a step's cells and means would exceed 32 bits.
constexpr std::size_t kMaxTriangles = std::size_t{1} << 28;

void place(const std::vector<Point3>& points, const Pose& pose, double time, Point4* into) {
  const model::Affine3x4 matrix = pose.matrix();
  for (const Point3& point : points) *into++ << model::posed(matrix, point), time;
}

/// The flipped mesh if the given one is inside out, nothing if it faces outward.
Result<std::optional<TriangleMesh>> flippedIfInsideOut(const TriangleMesh& mesh) {
  const double volume = signedVolume(mesh);
  if (volume > 0) return std::nullopt;
  if (volume < 0) {
    TriangleMesh flipped = mesh;
    for (model::Triangle& triangle : flipped.triangles) std::swap(triangle[1], triangle[2]);
    return flipped;
  }
  return invalid("the mesh encloses no volume");
}

/// Doubles must tell apart the corners of the solid wherever the motion takes it: beyond its own
/// size times this, its shape is lost.
constexpr double kFinestFraction = 1.0 / 1024;

/// Checks that the coordinates that the motion reaches are neither so large that the solid's shape
/// is lost in their rounding, nor beyond what can be measured.
Result<void> checkReach(const TriangleMesh& mesh, const model::Motion& motion) {
  const model::Bounds3 bounds = boundsOf(mesh);
  const model::Point3 extent = bounds.max - bounds.min;
  const double width = extent.minCoeff();
  const Point3 middle = bounds.min / 2 + bounds.max / 2;
  const double farthest = bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).maxCoeff();
  if (!(farthest <= model::kLargestCoordinate)) {
    return invalid(fmt::format("has coordinates of {:.3g}; the largest that can be swept is {}",
                               farthest, model::kLargestCoordinate));
  }
  if (!(width >= model::kSmallestExtent)) {
    return invalid(fmt::format("is {:.3g} wide; the smallest solid that can be swept is {} wide",
                               width, model::kSmallestExtent));
  }
  const auto spacing = [](double coordinate) {
    return coordinate * std::numeric_limits<double>::epsilon();
  };
  for (std::size_t i = 0; i < motion.segments.size(); ++i) {
    const model::Segment& segment = motion.segments[i];
    // Both ends, and eighths of the first turn.
    const double eighth = 45 / std::max(45.0, std::abs(segment.screw.angleDegrees));
    double reach = std::max(segment.start(middle).norm(), segment.end(middle).norm());
    for (int k = 1; k <= 8 && segment.screw.angleDegrees != 0; ++k) {
      reach = std::max(reach, segment.at(std::min(1.0, k * eighth))(middle).norm());
    }
    if (spacing(reach) <= kFinestFraction * width) continue;
    return invalid(fmt::format("segment {} moves the solid about coordinates of {:.3g}, where "
                               "doubles are {:.3g} apart; the solid is only {:.3g} wide. Move it "
                               "nearer to the origin",
                               i, reach, spacing(reach), width),
                   {}, Remedy::Motion);
  }
  return {};
}

/// A notice about the first step with an angle so large that it hardly follows the motion.
std::optional<std::string> noticeOfLargeTurn(const model::Motion& motion,
                                             const std::vector<std::uint64_t>& counts) {
  // At 90 degrees the volume in the middle of the step is half the solid's; allow for rounding.
  constexpr double kLargeDegrees = 90 * (1 + 1e-9);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double degrees =
        std::abs(motion.segments[i].screw.angleDegrees) / static_cast<double>(counts[i]);
    if (degrees <= kLargeDegrees) continue;
    return fmt::format(
        "a step of segment {} turns by {:.4g} degrees; vertices move on a straight line in a step, "
        "so between its times the mesh is far from the motion: more steps are needed",
        i, degrees);
  }
  return std::nullopt;
}

class Sweeper {
 public:
  Sweeper(const TriangleMesh& mesh, const model::Motion& motion, const SweepOptions& options,
          model::Sink& sink, const model::Progress& progress)
      : mesh_(mesh),
        motion_(motion),
        options_(options),
        sink_(sink),
        progress_(progress),
        reference_(std::make_shared<const std::vector<Point3>>(mesh.vertices)) {}

  Result<SweepReport> run() {
    auto counts = stepsOf(motion_, options_.steps, mesh_.vertices);
    if (!counts) return pass(counts.error());
    report_.steps = std::accumulate(counts->begin(), counts->end(), std::uint64_t{0});
    if (auto notice = noticeOfLargeTurn(motion_, *counts)) {
      report_.notices.push_back(std::move(*notice));
    }
    const SweepPart& part = options_.part;
    if (report_.steps < part.count) {
      return invalid(fmt::format("the motion has {} step{}, too few for {} parts", report_.steps,
                                 report_.steps == 1 ? "" : "s", part.count),
                     {}, Remedy::StepRule);
    }
    const StepRange range = {stepsBefore(part.number - 1), stepsBefore(part.number)};
    const bool first = part.number == 1;
    const bool last = part.number == part.count;
    Cap cap;
    if (first || last) {
      auto filled = fillSolid(mesh_, options_.caps);
      if (!filled) return pass(filled.error());
      cap = std::move(*filled);
    }
    if (first) {
      if (auto done = putStartCap(cap); !done) return pass(done.error());
    }
    if (auto done = putSteps(*counts, range); !done) return pass(done.error());
    if (last) {
      if (auto done = putEndCap(cap); !done) return pass(done.error());
    }
    report_.steps = range.end - range.begin;
    report_.capTetrahedra = {first ? cap.cells.size() : 0, last ? cap.cells.size() : 0};
    return report_;
  }

 private:
  /// Consecutive steps, counted through all segments.
  struct StepRange {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
  };

  /// The steps of the first `parts` parts.
  std::uint64_t stepsBefore(std::uint64_t parts) const {
    const std::uint64_t each = report_.steps / options_.part.count;
    return parts * each + std::min(parts, report_.steps % options_.part.count);
  }

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(mesh_.vertices.size()); }

  std::shared_ptr<const model::LayerPose> poseOf(const Pose& pose) const {
    return std::make_shared<const model::LayerPose>(
        model::LayerPose{reference_, pose.matrix(), false});
  }

  Result<void> put(const Slab& slab) {
    const model::Connectivity& connectivity = *slab.connectivity;
    report_.vertices += connectivity.vertexCount - connectivity.lowerCount;
    report_.tetrahedra += connectivity.cells.size();
    return sink_.put(slab);
  }

  Result<void> putStartCap(const Cap& cap) {
    Slab slab;
    slab.timeBegin = slab.timeEnd = motion_.timeBegin();
    slab.connectivity = startCapConnectivity(cap, vertexCount());
    slab.vertices.resize(slab.connectivity->vertexCount);
    const Pose& pose = motion_.segments.front().start;
    place(cap.inner, pose, slab.timeEnd, slab.vertices.data());
    place(mesh_.vertices, pose, slab.timeEnd, slab.vertices.data() + cap.inner.size());
    slab.upperPose = poseOf(pose);
    return put(slab);
  }

  Result<void> putSteps(const std::vector<std::uint64_t>& counts, const StepRange& range) {
    Slab slab;
    slab.connectivity = stepConnectivity(mesh_, options_.prism);
    slab.vertices.resize(slab.connectivity->vertexCount);
    Point4* const lower = slab.vertices.data();
    Point4* const upper = lower + slab.connectivity->firstUpper();
    slab.timeEnd = motion_.timeBegin();
    place(mesh_.vertices, motion_.segments.front().start, slab.timeEnd, upper);
    std::uint64_t index = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const model::Segment& segment = motion_.segments[i];
      const model::TimeSpan span{segment.timeBegin, segment.timeEnd};
      for (std::uint64_t step = 1; step <= counts[i] && index < range.end; ++step, ++index) {
        const double fraction = static_cast<double>(step) / static_cast<double>(counts[i]);
        slab.timeBegin = slab.timeEnd;
        slab.timeEnd = dividedTime(span, step, counts[i]);
        if (!(slab.timeEnd > slab.timeBegin)) {
          return invalid(fmt::format("segment {} lasts {} from time {} on: doubles are too coarse "
                                     "there for {} steps; start at a smaller time, or allow "
                                     "larger steps",
                                     i, span.end - span.begin, span.begin, counts[i]),
                         {}, Remedy::Motion);
        }
        if (index + 1 < range.begin) continue;
        std::copy(upper, upper + vertexCount(), lower);
        const Pose pose = segment.at(fraction);
        place(mesh_.vertices, pose, slab.timeEnd, upper);
        if (index < range.begin) continue;
        const bool joined = index + 1 == range.end && index + 1 < report_.steps;
        slab.upperPose = joined ? nullptr : poseOf(pose);
        setMeans(*slab.connectivity, slab.vertices);
        if (auto put = this->put(slab); !put) return put;
        if (progress_) {
          progress_(static_cast<double>(index + 1 - range.begin) /
                    static_cast<double>(range.end - range.begin));
        }
      }
    }
    return {};
  }

  Result<void> putEndCap(const Cap& cap) {
    Slab slab;
    slab.timeBegin = slab.timeEnd = motion_.timeEnd();
    slab.connectivity = endCapConnectivity(cap, vertexCount());
    slab.vertices.resize(slab.connectivity->vertexCount);
    const Pose& pose = motion_.segments.back().end;
    place(mesh_.vertices, pose, slab.timeEnd, slab.vertices.data());
    place(cap.inner, pose, slab.timeEnd, slab.vertices.data() + vertexCount());
    return put(slab);
  }

  const TriangleMesh& mesh_;
  const model::Motion& motion_;
  const SweepOptions& options_;
  model::Sink& sink_;
  const model::Progress& progress_;
  std::shared_ptr<const std::vector<Point3>> reference_;
  SweepReport report_;
};

}  // namespace

Result<SweepReport> sweep(const TriangleMesh& mesh, const model::Motion& motion,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress) {
  if (auto checked = model::checkClosedSurface(mesh); !checked) return pass(checked.error());
  if (mesh.triangles.size() > kMaxTriangles) {
    return invalid(fmt::format("the mesh has {} triangles; at most {} can be swept",
                               mesh.triangles.size(), kMaxTriangles));
  }
  if (motion.segments.empty()) return invalid("the motion has no segment");
  if (auto checked = checkReach(mesh, motion); !checked) return pass(checked.error());
  auto flipped = flippedIfInsideOut(mesh);
  if (!flipped) return pass(flipped.error());
  auto report = Sweeper(*flipped ? **flipped : mesh, motion, options, sink, progress).run();
  if (!report) return report;
  if (*flipped) report->notices.emplace_back("the mesh was inside out and was flipped");
  if (options.caps == CapMethod::Cone) {
    report->notices.emplace_back(
        "both ends are closed by cones: hypervolume and slices are exact, but cells may overlap "
        "inside the two caps, and the apex's link need not be a sphere");
  }
  return report;
}

}  // namespace t4d::mesh4d
