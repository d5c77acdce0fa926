#include "t4d/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "mesh4d/cap.h"
#include "mesh4d/folds.h"
#include "mesh4d/motion_keys.h"
#include "mesh4d/prism.h"
#include "mesh4d/step_crossings.h"
#include "mesh4d/steps.h"
#include "model/corner_attributes.h"
#include "model/limits.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "model/surface_check.h"

namespace t4d::mesh4d {
namespace {

using model::Point3;
using model::Point4;
using model::Slab;
using model::TriangleMesh;
using model::VertexKeys;

/// With more triangles, the indices of a step's cells and means would exceed 32 bits.
constexpr std::size_t kMaxTriangles = std::size_t{1} << 28;

/// Turns every triangle over, with what attributes have of its corners.
void flip(TriangleMesh& mesh) {
  for (model::Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  for (model::Attribute& attribute : mesh.attributes) {
    const bool ofCorners = attribute.domain == model::Domain::Cell &&
                           attribute.name.ends_with(model::kCornersOf) &&
                           attribute.components % 3 == 0;
    if (!ofCorners) continue;
    const auto bytes = static_cast<std::ptrdiff_t>(attribute.rowBytes() / 3);
    for (auto at = attribute.values.begin(); at != attribute.values.end(); at += 3 * bytes) {
      std::swap_ranges(at + bytes, at + 2 * bytes, at + 2 * bytes);
    }
  }
}

/// The flipped mesh if the given one is inside out, nothing if it faces outward.
Result<std::optional<TriangleMesh>> flippedIfInsideOut(const TriangleMesh& mesh) {
  const double volume = signedVolume(mesh);
  if (volume > 0) return std::nullopt;
  if (volume < 0) {
    TriangleMesh flipped = mesh;
    flip(flipped);
    return flipped;
  }
  return invalid("the mesh encloses no volume");
}

/// Doubles must tell apart the corners of the solid wherever the motion takes it: beyond its own
/// size times this, its shape is lost.
constexpr double kFinestFraction = 1.0 / 1024;

double spacing(double coordinate) { return coordinate * std::numeric_limits<double>::epsilon(); }

double farthestOf(const model::Bounds3& bounds) {
  return bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).maxCoeff();
}

/// checkReach for the vertices at one key. `width` is that of the solid along its longest axis at
/// the keys before, and grows to that of this one: a solid may shrink to nothing, but not by
/// rounding.
Result<void> checkKey(double time, std::span<const Point3> positions, double& width) {
  model::Bounds3 bounds;
  for (const Point3& position : positions) {
    bounds.add(position);
    if ((position.array().abs() <= model::kLargestCoordinate).all()) continue;
    return invalid(fmt::format("vertex {} is at ({}, {}, {}) at time {}; the largest coordinate "
                               "that can be swept is {}",
                               &position - positions.data(), position.x(), position.y(),
                               position.z(), time, model::kLargestCoordinate),
                   {}, Remedy::Motion);
  }
  width = std::max(width, (bounds.max - bounds.min).maxCoeff());
  const double farthest = farthestOf(bounds);
  if (spacing(farthest) <= kFinestFraction * width) return {};
  return invalid(fmt::format("the solid has coordinates of {:.3g} at time {}, where doubles are "
                             "{:.3g} apart, and is only {:.3g} wide. Move it nearer to the origin",
                             farthest, time, spacing(farthest), width),
                 {}, Remedy::Motion);
}

/// An error that is that of a key, not of the mesh whose triangles move.
Error atKey(const VertexKeys& keys, std::uint64_t key, Error error) {
  error.where = placeIn({}, fmt::format("key {}, at time {}", key, keys.time(key)));
  error.where.key = key;
  return error;
}

/// Whether no step turns by more than half a turn, but for rounding. From pose to pose, readers
/// take the motion to be the screw of at most that.
bool isGivenByPoses(const model::Motion& motion, const std::vector<std::uint64_t>& counts) {
  constexpr double kHalfTurn = 180 * (1 + 1e-9);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double degrees = std::abs(motion.segments[i].screw.angleDegrees);
    if (degrees > kHalfTurn * static_cast<double>(counts[i])) return false;
  }
  return true;
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

/// A notice where long edges are what asks for many steps.
std::optional<std::string> noticeOfLongEdges(const model::Motion& motion, const StepRule& rule,
                                             const std::vector<std::uint64_t>& counts,
                                             std::vector<model::Chords> chords) {
  constexpr std::uint64_t kMany = 10'000;
  constexpr double kTimes = 10;
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (!std::holds_alternative<MaxDeviation>(rule) || total < kMany) return std::nullopt;
  double longest = 0;
  for (model::Chords& one : chords) {
    longest = std::max(longest, one.edge);
    one.edge /= kTimes;
  }
  const auto fewer = stepsOf(motion, rule, chords);
  if (!fewer) return std::nullopt;
  const std::uint64_t others = std::accumulate(fewer->begin(), fewer->end(), std::uint64_t{0});
  if (static_cast<double>(total) < 0.5 * kTimes * static_cast<double>(others)) return std::nullopt;
  return fmt::format(
      "{} steps, because of long edges: between two layers a slice deviates in proportion to the "
      "longest edge, {:.3g}. With edges a tenth as long, {} steps would do",
      total, longest, others);
}

class Sweeper {
 public:
  Sweeper(const TriangleMesh& mesh, const VertexKeys& keys, const SweepOptions& options,
          model::Sink& sink, const model::Progress& progress)
      : mesh_(mesh),
        keys_(keys),
        options_(options),
        sink_(sink),
        progress_(progress),
        reference_(std::make_shared<const std::vector<Point3>>(mesh.vertices)),
        positions_(mesh.vertices.size()) {}

  /// `statesPoses`: whether slabs state the poses of their layers, if these have any.
  Result<SweepReport> run(bool lookForFolds, bool statesPoses) {
    statesPoses_ = statesPoses;
    report_.steps = keys_.count() - 1;
    const model::Part& part = options_.part;
    if (report_.steps < part.count) {
      return invalid(fmt::format("the motion has {} step{}, too few for {} parts", report_.steps,
                                 report_.steps == 1 ? "" : "s", part.count),
                     {}, Remedy::StepRule);
    }
    const StepRange range = part.of(report_.steps);
    // Both ends are filled first, so that an end that cannot be filled is found at once.
    std::optional<Cap> startCap;
    std::optional<Cap> endCap;
    if (part.isFirst()) {
      auto filled = fill(0, nullptr);
      if (!filled) return filled.error();
      startCap = std::move(*filled);
    }
    if (part.isLast()) {
      auto filled = fill(keys_.count() - 1, startCap ? &*startCap : nullptr);
      if (!filled) return filled.error();
      endCap = std::move(*filled);
    }
    if (startCap) {
      if (auto done = putStartCap(*startCap); !done) return done.error();
    }
    if (auto done = putSteps(range, lookForFolds); !done) return done.error();
    if (endCap) {
      if (auto done = putEndCap(*endCap); !done) return done.error();
    }
    report_.steps = range.end - range.begin;
    report_.capTetrahedra = {startCap ? startCap->cells.size() : 0,
                             endCap ? endCap->cells.size() : 0};
    return report_;
  }

 private:
  /// Step i leads from key i to key i + 1.
  using StepRange = model::PartRange;

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(mesh_.vertices.size()); }

  /// Reads the positions of a key and checks them.
  Result<void> load(std::uint64_t key) {
    if (auto read = keys_.positions(key, positions_); !read) return read;
    auto good = checkKey(keys_.time(key), positions_, width_);
    return good || keys_.pose(key) ? good : atKey(keys_, key, good.error());
  }

  /// Puts the layer of a key at `into`.
  Result<void> place(std::uint64_t key, Point4* into) {
    if (auto loaded = load(key); !loaded) return loaded;
    const double time = keys_.time(key);
    for (const Point3& position : positions_) *into++ << position, time;
    return {};
  }

  std::shared_ptr<const model::LayerPose> poseOf(std::uint64_t key) const {
    const auto pose = keys_.pose(key);
    if (!pose || !statesPoses_) return nullptr;
    return std::make_shared<const model::LayerPose>(model::LayerPose{reference_, *pose, false});
  }

  /// The cap at a key. Where that has a pose, the mesh itself is filled and the result moved; a cap
  /// `known` of another key with a pose has the same cells.
  Result<Cap> fill(std::uint64_t key, const Cap* known) {
    const auto pose = keys_.pose(key);
    if (!pose) {
      if (auto loaded = load(key); !loaded) return loaded.error();
      auto filled = fillSolid({positions_, mesh_.triangles, {}}, options_.caps);
      return filled ? filled : atKey(keys_, key, filled.error());
    }
    if (known != nullptr && keys_.pose(0)) return *known;
    return fillSolid(mesh_, options_.caps);
  }

  /// Puts the inner points of a cap at `into`.
  void placeInner(const Cap& cap, std::uint64_t key, Point4* into) const {
    const auto pose = keys_.pose(key);
    const double time = keys_.time(key);
    for (const Point3& point : cap.inner) {
      *into++ << (pose ? model::posed(*pose, point) : point), time;
    }
  }

  void count(const Slab& slab) {
    const model::Connectivity& connectivity = *slab.connectivity;
    report_.vertices += connectivity.vertexCount - connectivity.lowerCount;
    report_.tetrahedra += connectivity.cells.size();
  }

  Result<void> put(const Slab& slab) {
    count(slab);
    return sink_.put(slab);
  }

  Result<void> putStartCap(const Cap& cap) {
    Slab slab;
    slab.timeBegin = slab.timeEnd = keys_.time(0);
    slab.connectivity = startCapConnectivity(cap, mesh_);
    slab.vertices.resize(slab.connectivity->vertexCount);
    placeInner(cap, 0, slab.vertices.data());
    if (auto placed = place(0, slab.vertices.data() + cap.inner.size()); !placed) return placed;
    slab.upperPose = poseOf(0);
    return put(slab);
  }

  /// A step on its way through the threads.
  struct Step {
    Result<void> read;
    std::uint64_t number = 0;
    std::shared_ptr<const std::vector<Point3>> lower;
    std::shared_ptr<const std::vector<Point3>> upper;
    Slab slab;
    std::unique_ptr<model::Sink::Prepared> prepared;
    std::optional<Fold> fold;
  };
  using StepPointer = std::shared_ptr<Step>;

  Result<void> putSteps(const StepRange& range, bool lookForFolds) {
    const std::uint64_t steps = range.end - range.begin;
    const auto connectivity = stepConnectivity(mesh_, options_.prism);
    if (auto loaded = load(range.begin); !loaded) return loaded;
    auto last = std::make_shared<const std::vector<Point3>>(positions_);
    const auto read = [&](std::size_t i) {
      auto step = std::make_shared<Step>();
      step->number = range.begin + i;
      step->lower = last;
      step->read = readStep(step->number);
      if (!step->read) return step;
      step->upper = last = std::make_shared<const std::vector<Point3>>(positions_);
      const bool joined = step->number + 1 == range.end && range.end + 1 < keys_.count();
      if (!joined) step->slab.upperPose = poseOf(step->number + 1);
      step->slab.connectivity = connectivity;
      return step;
    };
    const auto make = [&](StepPointer step) {
      if (step->read) makeStep(*step, lookForFolds);
      return step;
    };
    Result<void> result;
    const auto take = [&](const StepPointer& step) {
      result = step->read ? takeStep(*step, lookForFolds) : step->read;
      if (result) result = model::report(progress_, step->number + 1 - range.begin, steps);
      return result.has_value();
    };
    model::inOrder<StepPointer, StepPointer>(steps, model::slabsAtOnce(connectivity->cells.size()),
                                             read, make, take);
    return result;
  }

  /// Reads the key at which a step ends.
  Result<void> readStep(std::uint64_t step) {
    const std::uint64_t key = step + 1;
    if (auto loaded = load(key); !loaded) return loaded;
    if (keys_.time(key) > keys_.time(step)) return {};
    return invalid(fmt::format("key {} is at time {}, not after the key before it, at {}: times "
                               "must increase",
                               key, keys_.time(key), keys_.time(step)),
                   {}, Remedy::Motion);
  }

  void makeStep(Step& step, bool lookForFolds) const {
    Slab& slab = step.slab;
    slab.timeBegin = keys_.time(step.number);
    slab.timeEnd = keys_.time(step.number + 1);
    slab.vertices.resize(slab.connectivity->vertexCount);
    Point4* into = slab.vertices.data();
    for (const Point3& position : *step.lower) *into++ << position, slab.timeBegin;
    into = slab.vertices.data() + slab.connectivity->firstUpper();
    for (const Point3& position : *step.upper) *into++ << position, slab.timeEnd;
    setMeans(*slab.connectivity, slab.vertices);
    if (lookForFolds && !movesOnly(step.number)) step.fold = foldOf(mesh_, slab);
    step.prepared = sink_.prepare(slab);
  }

  /// Whether a step leads from a pose to a pose by way of which no solid turns over.
  bool movesOnly(std::uint64_t step) const {
    const auto from = keys_.pose(step);
    const auto to = keys_.pose(step + 1);
    return from && to && foldsNowhere(*from, *to);
  }

  Result<void> takeStep(const Step& step, bool lookForFolds) {
    if (step.fold) note(*step.fold);
    // Between two poses all vertices move by one affine map, in which nothing meets.
    if (lookForFolds && (!keys_.pose(step.number) || !keys_.pose(step.number + 1))) {
      if (auto noted = noteCrossing(step.slab); !noted) return noted;
    }
    count(step.slab);
    return sink_.putPrepared(step.slab, step.prepared.get());
  }

  void note(const Fold& fold) {
    report_.foldedPrisms += fold.prisms;
    ++report_.foldedSteps;
    if (report_.folds.size() < kMostFolds) report_.folds.push_back(fold);
  }

  Result<void> noteCrossing([[maybe_unused]] const Slab& slab) {
#ifdef T4D_WITH_CGAL
    report_.soughtCrossings = true;
    const auto crossing = crossingOf(mesh_, slab);
    if (!crossing) return crossing.error();
    if (!*crossing) return {};
    if (!(*crossing)->complete) ++report_.unfinishedSteps;
    if ((*crossing)->pairs == 0) return {};
    report_.crossingPairs += (*crossing)->pairs;
    ++report_.crossingSteps;
    if (report_.crossings.size() < kMostFolds) report_.crossings.push_back(**crossing);
#endif
    return {};
  }

  Result<void> putEndCap(const Cap& cap) {
    const std::uint64_t key = keys_.count() - 1;
    Slab slab;
    slab.timeBegin = slab.timeEnd = keys_.time(key);
    slab.connectivity = endCapConnectivity(cap, mesh_);
    slab.vertices.resize(slab.connectivity->vertexCount);
    if (auto placed = place(key, slab.vertices.data()); !placed) return placed;
    placeInner(cap, key, slab.vertices.data() + vertexCount());
    return put(slab);
  }

  const TriangleMesh& mesh_;
  const VertexKeys& keys_;
  const SweepOptions& options_;
  model::Sink& sink_;
  const model::Progress& progress_;
  std::shared_ptr<const std::vector<Point3>> reference_;
  std::vector<Point3> positions_;
  double width_ = 0;  // of the solid, the greatest so far
  bool statesPoses_ = true;
  SweepReport report_;
};

Result<void> checkSolid(const TriangleMesh& mesh) {
  if (auto checked = model::checkClosedSurface(mesh); !checked) return checked;
  for (const model::Attribute& attribute : mesh.attributes) {
    const std::size_t rows =
        attribute.domain == model::Domain::Vertex ? mesh.vertices.size() : mesh.triangles.size();
    if (attribute.rowBytes() > 0 && attribute.values.size() == rows * attribute.rowBytes()) {
      continue;
    }
    return invalid(fmt::format("attribute '{}' of the mesh has {} rows, expected {}",
                               attribute.name, attribute.rows(), rows));
  }
  if (mesh.triangles.size() <= kMaxTriangles) return {};
  return invalid(fmt::format("the mesh has {} triangles; at most {} can be swept",
                             mesh.triangles.size(), kMaxTriangles));
}

void addFoldNotice(SweepReport& report) {
  if (report.foldedPrisms == 0) return;
  const Fold& first = report.folds.front();
  report.notices.push_back(fmt::format(
      "{} prism{} in {} of {} steps fold{}: the surface turns over or collapses there, so slices "
      "cross themselves. The first is that of triangle {} between the times {} and {}, about ({}, "
      "{}, {}); keys closer together, or for joints a smaller maximum deviation, may help",
      report.foldedPrisms, report.foldedPrisms == 1 ? "" : "s", report.foldedSteps, report.steps,
      report.foldedPrisms == 1 ? "s" : "", first.triangle, first.time.begin, first.time.end,
      first.place.x(), first.place.y(), first.place.z()));
}

void addCrossingNotices(SweepReport& report) {
  if (report.crossingPairs > 0) {
    const StepCrossing& first = report.crossings.front();
    report.notices.push_back(fmt::format(
        "{} pair{} of triangles in {} of {} steps meet{} between keys, so slices cross themselves. "
        "The first are the triangles {} and {} at time {:.9g}, about ({:.6g}, {:.6g}, {:.6g}); "
        "keys closer together may help",
        report.crossingPairs, report.crossingPairs == 1 ? "" : "s", report.crossingSteps,
        report.steps, report.crossingPairs == 1 ? "s" : "", first.triangles[0], first.triangles[1],
        first.at, first.place.x(), first.place.y(), first.place.z()));
  }
  if (report.unfinishedSteps > 0) {
    report.notices.push_back(fmt::format(
        "in {} of {} steps more than {} pairs of triangles have paths that overlap; the search for "
        "self-crossings ended there. Keys closer together make it complete",
        report.unfinishedSteps, report.steps, kMostSweptPairs));
  }
}

void addNotices(const SweepOptions& options, bool flipped, SweepReport& report) {
  if (flipped) report.notices.emplace_back("the mesh was inside out and was flipped");
  if (options.caps == CapMethod::Cone) {
    report.notices.emplace_back(
        "both ends are closed by cones: hypervolume and slices are exact, but cells may overlap "
        "inside the two caps, and the apex's link need not be a sphere");
  }
  addFoldNotice(report);
  addCrossingNotices(report);
}

}  // namespace

Result<void> checkReach(const TriangleMesh& mesh, const model::Motion& motion) {
  const model::Bounds3 bounds = boundsOf(mesh);
  const model::Point3 extent = bounds.max - bounds.min;
  const double width = extent.minCoeff();
  const Point3 middle = bounds.min / 2 + bounds.max / 2;
  const double farthest = farthestOf(bounds);
  if (!(farthest <= model::kLargestCoordinate)) {
    return invalid(fmt::format("has coordinates of {:.3g}; the largest that can be swept is {}",
                               farthest, model::kLargestCoordinate));
  }
  if (!(width >= model::kSmallestExtent)) {
    return invalid(fmt::format("is {:.3g} wide; the smallest solid that can be swept is {} wide",
                               width, model::kSmallestExtent));
  }
  for (std::size_t i = 0; i < motion.segments.size(); ++i) {
    const model::Segment& segment = motion.segments[i];
    // The places are both ends, and eighths of the first turn.
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

Result<SweepReport> sweep(const TriangleMesh& mesh, const model::Motion& motion,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress) {
  if (auto checked = checkSolid(mesh); !checked) return checked.error();
  if (motion.segments.empty()) return invalid("the motion has no segment");
  if (auto checked = checkReach(mesh, motion); !checked) return checked.error();
  const auto flipped = flippedIfInsideOut(mesh);
  if (!flipped) return flipped.error();
  const TriangleMesh& solid = *flipped ? **flipped : mesh;
  const auto chords = chordsOf(motion, solid, options.prism);
  const auto steps = stepsOf(motion, options.steps, chords, options.maxSteps);
  if (!steps) return steps.error();
  auto report = Sweeper(solid, MotionKeys(solid, motion, *steps), options, sink, progress)
                    .run(false, isGivenByPoses(motion, *steps));
  if (!report) return report;
  report->chordBound = largestDeviation(motion, *steps, chords);
  if (auto notice = noticeOfLargeTurn(motion, *steps)) {
    report->notices.push_back(std::move(*notice));
  }
  if (auto notice = noticeOfLongEdges(motion, options.steps, *steps, chords)) {
    report->notices.push_back(std::move(*notice));
  }
  addNotices(options, flipped->has_value(), *report);
  return report;
}

Result<SweepReport> sweep(const TriangleMesh& mesh, const VertexKeys& keys,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress) {
  if (auto checked = checkSolid(mesh); !checked) return checked.error();
  if (keys.count() < 2) {
    return invalid(
        fmt::format("there {} {} key{}; at least two are needed", keys.count() == 1 ? "is" : "are",
                    keys.count(), keys.count() == 1 ? "" : "s"),
        {}, Remedy::Motion);
  }
  TriangleMesh first{std::vector<Point3>(mesh.vertices.size()), mesh.triangles, {}};
  if (auto read = keys.positions(0, first.vertices); !read) return read.error();
  double width = 0;
  if (auto good = checkKey(keys.time(0), first.vertices, width); !good) {
    return atKey(keys, 0, good.error());
  }
  const auto flipped = flippedIfInsideOut(first);
  if (!flipped) return atKey(keys, 0, flipped.error());
  TriangleMesh solid = mesh;
  if (*flipped) flip(solid);
  auto report = Sweeper(solid, keys, options, sink, progress).run(true, true);
  if (!report) return report;
  addNotices(options, flipped->has_value(), *report);
  return report;
}

}  // namespace t4d::mesh4d
