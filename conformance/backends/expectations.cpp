#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "measure/triangle_tree.h"
#include "mesh4d/steps.h"
#include "model/degrees.h"
#include "t4d/check.h"
#include "t4d/conformance.h"
#include "voxel4d/frame_layer.h"

namespace t4d::conformance {
namespace {

using model::Bounds3;
using model::Point3;
using model::Segment;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The maximum speed of a moving mesh.
struct Speed {
  double length = 0;        ///< of any of its points, in length units per unit of time
  double angleRadians = 0;  ///< of its rotation, per unit of time
};

/// The largest distance of the mesh from the segment's axis, taken at the start: rotation about the
/// axis does not change it.
double radiusAbout(const Segment& segment, const MovingMesh& moving) {
  double radius = 0;
  for (const Point3& vertex : moving.mesh.vertices) {
    const Eigen::Vector3d arm = segment.start(vertex) - segment.screw.axisPoint;
    radius = std::max(radius, arm.cross(segment.screw.axisDirection).norm());
  }
  return radius;
}

Speed speedOf(const MovingMesh& moving) {
  Speed fastest;
  for (const Segment& segment : moving.motion.segments) {
    const double radius = radiusAbout(segment, moving);
    const double duration = segment.timeEnd - segment.timeBegin;
    const double angle = std::abs(segment.screw.angleDegrees) * model::kRadiansPerDegree / duration;
    fastest.angleRadians = std::max(fastest.angleRadians, angle);
    fastest.length =
        std::max(fastest.length, angle * radius + segment.screw.translation.norm() / duration);
  }
  return fastest;
}

double speedOf(const Case& given) {
  return given.mesh ? speedOf(*given.mesh).length : given.field->speed;
}

void addPosed(Bounds3& bounds, const MovingMesh& moving, const model::Pose& pose) {
  for (const Point3& vertex : moving.mesh.vertices) bounds.add(pose(vertex));
}

Surface surfaceOf(const model::TriangleMesh& mesh) {
  Surface surface;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Eigen::Vector3d> normals;
  for (const model::Triangle& triangle : mesh.triangles) {
    const auto corner = [&](int i) { return mesh.vertices[triangle[i % 3]]; };
    const Eigen::Vector3d normal =
        (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (int i = 0; i < 3; ++i) {
      const auto edge = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      const auto [other, isNew] = normals.try_emplace(edge, normal);
      if (isNew) continue;
      surface.bending += (corner(i + 1) - corner(i)).norm() * (normal - other->second).norm();
    }
  }
  surface.area = surfaceArea(mesh);
  return surface;
}

std::vector<int> generaOf(const fixtures::Topology& topology) {
  std::vector<int> genera(static_cast<std::size_t>(topology.components), 0);
  if (!genera.empty()) genera.front() = topology.genus;
  return genera;
}

/// A function that returns a point's distance from the true surface at a time.
std::function<double(const Point3&)> distanceAt(
    const Case& given, const std::shared_ptr<const measure::TriangleTree>& tree, double time) {
  if (given.field) {
    return [value = given.field->value, time](const Point3& point) { return value(point, time); };
  }
  const model::Pose pose = given.mesh->motion.at(time);
  return [tree, pose](const Point3& point) {
    return tree->nearest(pose.rotation.transpose() * (point - pose.translation)).distance;
  };
}

/// The slices of a case. `volume` returns the expected volume at a time; vertices may lie up to
/// `off` from the true surface.
template <class Volume>
std::vector<SliceExpectation> slicesOf(const Case& given, const Volume& volume, double off,
                                       const std::string& reason) {
  const auto tree =
      given.mesh ? std::make_shared<measure::TriangleTree>(given.mesh->mesh) : nullptr;
  std::vector<SliceExpectation> slices;
  const auto add = [&](double time) {
    SliceExpectation& slice = slices.emplace_back();
    slice.time = time;
    slice.volume = volume(time);
    slice.surface.emplace();
    slice.surface->distance = distanceAt(given, tree, time);
    slice.surface->tolerance = off;
    slice.surface->reason = reason;
    if (given.mesh) slice.genera = given.mesh->genera;
  };
  for (const double time : given.sliceTimes()) add(time);
  if (!given.field) return slices;
  for (const fixtures::Topology& topology : given.field->topology) {
    const auto same = [&](const SliceExpectation& slice) { return slice.time == topology.time; };
    if (std::none_of(slices.begin(), slices.end(), same)) add(topology.time);
    std::find_if(slices.begin(), slices.end(), same)->genera = generaOf(topology);
  }
  return slices;
}

/// The contact at a time, for a surface up to `off` from the true one; nothing if the closed form
/// does not hold that far.
std::optional<ContactExpectation> contactOf(const Case& given, double time, double off,
                                            const std::string& reason) {
  if (!(off <= given.obstacle->depth)) return std::nullopt;
  return ContactExpectation{given.obstacle->source,
                            {time, off / given.obstacle->leastSpeed, reason}};
}

/// The components of a mesh that moves rigidly: each lasts from begin to end. Of a field, its
/// events for a surface up to `off` from the true one; nothing if the closed form does not hold
/// that far.
std::optional<TracksExpectation> tracksOf(const Case& given, double off,
                                          const std::string& reason) {
  if (given.mesh) {
    return TracksExpectation{measure::measuresOf(given.mesh->mesh).components, {}};
  }
  TracksExpectation tracks{given.tracks, {}};
  for (const TopologyEvent& event : given.events) {
    if (!(off <= event.depth)) return std::nullopt;
    tracks.events.push_back({event.kind, {event.time, off / event.leastSpeed, reason}});
  }
  if (tracks.events.empty()) return std::nullopt;
  return tracks;
}

/// When the point that touches the obstacle first, on chords between the poses of the steps, is at
/// its face.
double contactOnChords(const Case& given, const std::vector<std::uint64_t>& steps) {
  const Obstacle& obstacle = *given.obstacle;
  const auto behindFace = [&](const Segment& segment, double fraction, double time) {
    return segment.at(fraction)(obstacle.touching).x() - obstacle.faceX -
           obstacle.faceSpeed * (time - given.time().begin);
  };
  double timeBefore = given.time().begin;
  double before = behindFace(given.mesh->motion.segments.front(), 0, timeBefore);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Segment& segment = given.mesh->motion.segments[i];
    for (std::uint64_t k = 1; k <= steps[i]; ++k) {
      const double fraction = static_cast<double>(k) / static_cast<double>(steps[i]);
      const double time = std::lerp(segment.timeBegin, segment.timeEnd, fraction);
      const double behind = behindFace(segment, fraction, time);
      if (behind >= 0) return std::lerp(timeBefore, time, before / (before - behind));
      timeBefore = time;
      before = behind;
    }
  }
  return std::numeric_limits<double>::quiet_NaN();  // never
}

/// Bounds on the rounding errors of a swept mesh.
struct Rounding {
  double position = 0;  ///< of a vertex, in length units
  double volume = 0;    ///< of a slice
  double hypervolume = 0;
  double visitsVolume = 0;
  double normalSpeed = 0;
};

/// A pose is a product of at most one pose per segment and a translation, each accurate to a few
/// roundings of the largest coordinate. A mesh of F triangles has 14 F cells per slab, and a slice
/// cuts each into at most two triangles: summing their volumes adds one rounding of the largest
/// partial sum per triangle. Likewise, the hypervolume takes one rounding per cell, of the measure
/// of the boundary times its reach over four, and the visits volume one, of the volume that the
/// surface passes through; the mean normal speed is that over the area and time.
Rounding roundingOf(const MovingMesh& moving) {
  constexpr double kRoundingsOfAPose = 16;
  Bounds3 bounds;
  double largest = 0;
  for (const Segment& segment : moving.motion.segments) {
    addPosed(bounds, moving, segment.start);
    addPosed(bounds, moving, segment.end);
    largest = std::max(largest, segment.screw.axisPoint.cwiseAbs().maxCoeff());
  }
  const Speed speed = speedOf(moving);
  const double duration = moving.motion.timeEnd() - moving.motion.timeBegin();
  const double area = surfaceArea(moving.mesh);
  const double halfSize = 0.5 * (boundsOf(moving.mesh).max - boundsOf(moving.mesh).min).norm();
  const auto triangles = static_cast<double>(moving.mesh.triangles.size());
  largest = std::max({largest, bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff()});

  Rounding rounding;
  rounding.position =
      kRoundingsOfAPose * kEpsilon * largest * static_cast<double>(moving.motion.segments.size());
  rounding.volume = area * rounding.position + 28 * triangles * kEpsilon * area * halfSize / 3;
  const double reach = std::hypot((bounds.max - bounds.min).norm() + 2 * halfSize, duration);
  const double boundary = area * duration * std::hypot(1, speed.length) + 2 * moving.volume;
  rounding.hypervolume =
      duration * area * rounding.position + 14 * triangles * kEpsilon * boundary * reach / 4;
  rounding.visitsVolume =
      area * rounding.position +
      14 * triangles * kEpsilon * (moving.volume + area * duration * speed.length);
  rounding.normalSpeed = rounding.visitsVolume / (area * duration);
  return rounding;
}

/// The slice at fraction s of a step that turns by theta: V0 (1 - 2 s (1 - s) (1 - cos theta)).
double sliceOfStep(double volume, double s, double theta) {
  return volume * (1 - 2 * s * (1 - s) * (1 - std::cos(theta)));
}

}  // namespace

Result<Expectation> sweptExpectation(const Case& given, bool cones) {
  const MovingMesh& moving = *given.mesh;
  const model::Motion& motion = moving.motion;
  const auto steps = mesh4d::stepsOf(motion, mesh4d::MinVolumeRatio{given.minVolumeRatio});
  if (!steps) return steps.error();
  const Rounding rounding = roundingOf(moving);
  const std::string reason = "exact but for rounding";

  Expectation expectation;
  expectation.timeBegin = {motion.timeBegin(), 0, "exact"};
  expectation.timeEnd = {motion.timeEnd(), 0, "exact"};
  double longestEdge = 0;
  for (const model::Triangle& triangle : moving.mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d edge =
          moving.mesh.vertices[triangle[(i + 1) % 3]] - moving.mesh.vertices[triangle[i]];
      longestEdge = std::max(longestEdge, edge.norm());
    }
  }
  std::uint64_t allSteps = 0;
  double hypervolume = 0;
  double off = rounding.position;
  Bounds3 box;
  const auto thetaOf = [&](std::size_t i) {
    return motion.segments[i].screw.angleDegrees * model::kRadiansPerDegree /
           static_cast<double>((*steps)[i]);
  };
  for (std::size_t i = 0; i < steps->size(); ++i) {
    const Segment& segment = motion.segments[i];
    hypervolume +=
        moving.volume * (segment.timeEnd - segment.timeBegin) * (2 + std::cos(thetaOf(i))) / 3;
    for (std::uint64_t k = 0; k <= (*steps)[i]; ++k) {
      addPosed(box, moving, segment.at(static_cast<double>(k) / static_cast<double>((*steps)[i])));
    }
    allSteps += (*steps)[i];
    const double theta = std::abs(thetaOf(i));
    off = std::max(off, radiusAbout(segment, moving) * (1 - std::cos(theta / 2)) +
                            longestEdge * theta / 4 + rounding.position);
  }
  expectation.hypervolume = {hypervolume, rounding.hypervolume, reason};
  expectation.bounds = {box, rounding.position, reason};
  if (given.visitsVolume) {
    expectation.visitsVolume = {*given.visitsVolume, rounding.visitsVolume, reason};
  }
  if (given.meanNormalSpeed) {
    expectation.meanNormalSpeed = {*given.meanNormalSpeed, rounding.normalSpeed, reason};
  }
  if (given.obstacle) {
    expectation.contact =
        contactOf(given, contactOnChords(given, *steps), 2 * rounding.position, reason);
    if (expectation.contact) expectation.contact->canGiveWay = given.obstacle->canGiveWay;
  }
  expectation.tracks = tracksOf(given, 0, "a solid that moves rigidly stays as it is");
  const auto volumeAt = [&](double time) {
    std::size_t i = 0;
    while (i + 1 < motion.segments.size() && time >= motion.segments[i].timeEnd) ++i;
    const Segment& segment = motion.segments[i];
    const double at = (time - segment.timeBegin) / (segment.timeEnd - segment.timeBegin) *
                      static_cast<double>((*steps)[i]);
    return Measure{sliceOfStep(moving.volume, at - std::floor(at), thetaOf(i)), rounding.volume,
                   reason};
  };
  expectation.slices = slicesOf(given, volumeAt, off, "chords instead of arcs");

  const std::uint64_t v = moving.mesh.vertices.size();
  const std::uint64_t f = moving.mesh.triangles.size();
  const std::uint64_t e = 3 * f / 2;
  expectation.sideCounts = {(allSteps + 1) * v + allSteps * (e + f), 14 * f * allSteps};
  expectation.countsReason = "(steps + 1) V + steps (E + F) vertices, 14 F steps tetrahedra";
  expectation.manifoldCaps = !cones;
  if (cones) {
    expectation.counts = {expectation.sideCounts->vertices + 2,
                          expectation.sideCounts->tetrahedra + 2 * f};
    expectation.countsReason += ", and two cones";
  } else if (given.meshCounts) {
    expectation.counts = given.meshCounts;
    expectation.countsReason += "; the paper's Table 1";
  }
  return expectation;
}

std::vector<Resolution> voxelResolutions(const Case& given) {
  constexpr std::uint64_t kLeastSteps = 4;
  const model::TimeSpan span = given.time();
  std::vector<Resolution> resolutions;
  std::uint64_t steps = 0;
  for (const double size : given.voxels.voxelSizes) {
    if (given.voxels.mask) {
      steps = given.voxels.maskFrames - 1;
    } else if (steps == 0) {
      const double apart = given.voxels.maskMotion > 0 ? given.voxels.maskMotion : 1;
      const double voxels = (span.end - span.begin) * speedOf(given) / (size * apart);
      steps = std::max(given.voxels.maskMotion > 0 ? 1 : kLeastSteps,
                       static_cast<std::uint64_t>(std::ceil(voxels)));
    } else {
      steps *= 2;
    }
    resolutions.push_back({size, steps});
  }
  return resolutions;
}

Expectation voxelExpectation(const Case& given, const Resolution& resolution) {
  const double h = resolution.voxelSize;
  const model::TimeSpan span = given.time();
  const double duration = span.end - span.begin;
  const double frameTime = duration / static_cast<double>(resolution.steps);
  const double motion = speedOf(given) * frameTime;
  const double diameter2 = 3 * h * h + motion * motion;
  const double turn = given.mesh ? speedOf(*given.mesh).angleRadians * frameTime : 0;
  const Surface ofMesh = given.mesh ? surfaceOf(given.mesh->mesh) : Surface{};
  // The surface of a mask, and so its distance, is off by at most half the diagonal of a voxel.
  const double maskError = given.voxels.maskMotion > 0 ? std::numbers::sqrt3 / 2 * h : 0;
  const auto errorAt = [&](double time) {
    const Surface surface = given.mesh ? ofMesh : given.fieldSurface(time);
    const double normalError =
        turn * h * (2 * std::numbers::sqrt3 + 1) / 8 + voxel4d::kOffLattice * h;
    return surface.bending * diameter2 / 4 + surface.area * (normalError + maskError);
  };
  const std::string reason = maskError > 0
                                 ? "half a voxel's diagonal from the surface"
                                 : "bound of order h^2 for linear interpolation of the distance";

  Expectation expectation;
  expectation.timeBegin = {span.begin, 0, "flat caps lie exactly at the first frame's time"};
  expectation.timeEnd = {span.end, 0, "flat caps lie exactly at the last frame's time"};
  const double off = std::numbers::sqrt3 * h + motion;
  const std::string offReason = "a voxel's diagonal and the motion between two frames";
  expectation.slices = slicesOf(
      given,
      [&](double time) {
        return Measure{given.volumeAt(time), errorAt(time), reason};
      },
      off, offReason);
  // The surface of what moves may come and go within that distance, which counts as visits.
  if (given.visitsVolume && motion == 0) {
    expectation.visitsVolume = {*given.visitsVolume, errorAt(span.begin), reason};
  }
  if (given.obstacle) {
    expectation.contact = contactOf(given, given.obstacle->time, off, offReason);
  }
  expectation.tracks = tracksOf(given, off, offReason);
  if (const auto hypervolume = given.hypervolume()) {
    // The errors of the slices, summed over the frames.
    double error = 0;
    for (std::uint64_t i = 0; i < resolution.steps; ++i) {
      error += frameTime * errorAt(span.begin + (static_cast<double>(i) + 0.5) * frameTime);
    }
    expectation.hypervolume = {*hypervolume, error, reason};
  }
  if (given.mesh) {
    Bounds3 box;
    for (std::uint64_t i = 0; i <= resolution.steps; ++i) {
      addPosed(box, *given.mesh,
               given.mesh->motion.at(span.begin + static_cast<double>(i) * frameTime));
    }
    // Any ball of radius sqrt(3)/2 voxels contains a lattice point. In a cube's corner it touches
    // the three faces when its centre is sqrt(3) radii from the tip.
    const double tip = (1 + std::numbers::sqrt3) * std::numbers::sqrt3 / 2 * h;
    expectation.bounds = {box, tip, "a cube's tip that contains no lattice point is cut off"};
  }
  return expectation;
}

Expectation maskExpectation(const Case& given) {
  const MovingMesh& moving = *given.mesh;
  const double h = given.voxels.voxelSizes.front();
  const double last = static_cast<double>(given.voxels.maskFrames - 1);
  const double begin = moving.motion.timeBegin();
  const double rounding = 1e3 * kEpsilon * given.voxels.maskVolume;
  Expectation expectation;
  expectation.timeBegin = {begin, 0, "flat caps lie exactly at the first frame's time"};
  expectation.timeEnd = {begin + last, 0, "flat caps lie exactly at the last frame's time"};
  expectation.hypervolume = {given.voxels.maskVolume * last, rounding * last,
                             "exact but for rounding: a step encloses the mean of its two layers"};
  expectation.counts = given.voxels.counts;
  expectation.countsReason = "the paper's Table 1";
  const auto tree = std::make_shared<measure::TriangleTree>(moving.mesh);
  for (const double time : {0.0, std::floor(0.37 * last), last}) {
    SliceExpectation& slice = expectation.slices.emplace_back();
    slice.time = begin + time;
    slice.volume = {given.voxels.maskVolume, rounding, "exact but for rounding"};
    slice.surface.emplace();
    slice.surface->distance = distanceAt(given, tree, slice.time);
    slice.surface->tolerance = std::numbers::sqrt3 * h;
    slice.surface->reason = "a voxel's diagonal";
    slice.genera = moving.genera;
  }
  Bounds3 box;
  for (const double time : {0.0, last}) addPosed(box, moving, moving.motion.at(begin + time));
  box.min.array() += 0.5 * h;
  box.max.array() -= 0.5 * h;
  expectation.bounds = {box, 1e3 * kEpsilon * box.max.cwiseAbs().maxCoeff(),
                        "half a voxel within the cube, whose faces lie on lattice points"};
  return expectation;
}

Expectation solidExpectation(const Case& given, double relativeTolerance) {
  const MovingMesh& moving = *given.mesh;
  const model::TimeSpan span = given.time();
  const double duration = span.end - span.begin;
  const std::string reason = fmt::format("the true solid, within {:g}", relativeTolerance);
  Expectation expectation;
  expectation.timeBegin = {span.begin, relativeTolerance * duration, reason};
  expectation.timeEnd = {span.end, relativeTolerance * duration, reason};
  expectation.hypervolume = {moving.volume * duration, relativeTolerance * moving.volume * duration,
                             reason};
  // With this many poses, the mesh leaves the box between two of them by less than a millionth of
  // the path.
  constexpr int kPoses = 1024;
  Bounds3 box;
  for (int i = 0; i <= kPoses; ++i) {
    addPosed(box, moving, moving.motion.at(span.begin + duration * i / kPoses));
  }
  expectation.manifoldCaps = false;
  const double length = relativeTolerance * (box.max - box.min).norm();
  expectation.bounds = {box, length, reason + " of the diagonal"};
  if (given.visitsVolume) {
    expectation.visitsVolume = {*given.visitsVolume, relativeTolerance * *given.visitsVolume,
                                reason};
  }
  if (given.meanNormalSpeed) {
    expectation.meanNormalSpeed = {*given.meanNormalSpeed, relativeTolerance * speedOf(given),
                                   reason};
  }
  if (given.obstacle) {
    expectation.contact =
        contactOf(given, given.obstacle->time, length, reason + " of the diagonal");
  }
  expectation.tracks = tracksOf(given, length, reason + " of the diagonal");
  expectation.slices = slicesOf(
      given,
      [&](double) {
        return Measure{moving.volume, relativeTolerance * moving.volume, reason};
      },
      length, reason + " of the diagonal");
  return expectation;
}

}  // namespace t4d::conformance
