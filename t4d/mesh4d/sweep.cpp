#include "t4d/mesh4d/sweep.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

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
  for (const Point3& point : points) *into++ << pose(point), time;
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
      : mesh_(mesh), motion_(motion), options_(options), sink_(sink), progress_(progress) {}

  Result<SweepReport> run() {
    auto counts = stepsOf(motion_, options_.steps, mesh_.vertices);
    if (!counts) return pass(counts.error());
    report_.steps = std::accumulate(counts->begin(), counts->end(), std::uint64_t{0});
    if (auto notice = noticeOfLargeTurn(motion_, *counts)) {
      report_.notices.push_back(std::move(*notice));
    }
    auto cap = fillSolid(mesh_, options_.caps);
    if (!cap) return pass(cap.error());
    report_.capTetrahedra = {cap->cells.size(), cap->cells.size()};

    if (auto done = putStartCap(*cap); !done) return pass(done.error());
    if (auto done = putSteps(*counts); !done) return pass(done.error());
    if (auto done = putEndCap(*cap); !done) return pass(done.error());
    return report_;
  }

 private:
  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(mesh_.vertices.size()); }

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
    return put(slab);
  }

  Result<void> putSteps(const std::vector<std::uint64_t>& counts) {
    Slab slab;
    slab.connectivity = stepConnectivity(mesh_, options_.prism);
    slab.vertices.resize(slab.connectivity->vertexCount);
    Point4* const lower = slab.vertices.data();
    Point4* const upper = lower + slab.connectivity->firstUpper();
    slab.timeEnd = motion_.timeBegin();
    place(mesh_.vertices, motion_.segments.front().start, slab.timeEnd, upper);
    std::uint64_t done = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const model::Segment& segment = motion_.segments[i];
      const model::TimeSpan span{segment.timeBegin, segment.timeEnd};
      for (std::uint64_t step = 1; step <= counts[i]; ++step) {
        const double fraction = static_cast<double>(step) / static_cast<double>(counts[i]);
        slab.timeBegin = slab.timeEnd;
        slab.timeEnd = dividedTime(span, step, counts[i]);
        if (!(slab.timeEnd > slab.timeBegin)) {
          return invalid(fmt::format("segment {} lasts {} from time {} on, too short for {} steps",
                                     i, span.end - span.begin, span.begin, counts[i]));
        }
        std::copy(upper, upper + vertexCount(), lower);
        place(mesh_.vertices, segment.at(fraction), slab.timeEnd, upper);
        setMeans(*slab.connectivity, slab.vertices);
        if (auto put = this->put(slab); !put) return put;
        ++done;
        if (progress_) {
          progress_(static_cast<double>(done) / static_cast<double>(report_.steps));
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
