#include <cassert>
#include <cmath>
#include <numbers>

#include "conformance/backends/milling.h"
#include "fixtures/fields.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "model/degrees.h"
#include "t4d/conformance.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::conformance {
namespace {

using fixtures::Field;
using measure::TrackEventKind;
using model::Point3;
using model::ScrewRun;
using model::TriangleMesh;

/// A solid whose volume is known in closed form.
struct Solid {
  TriangleMesh mesh;
  double volume = 0;
  std::vector<int> genera;
};

Solid cube(double side) { return {fixtures::cube(side), side * side * side, {0}}; }

Solid paperCube() { return {fixtures::paperCube(20), 8000, {0}}; }

Solid hollowCube(double outer, double inner) {
  return {
      fixtures::hollowCube(outer, inner), outer * outer * outer - inner * inner * inner, {0, 0}};
}

/// The volume follows from Pappus's theorem, with polygons in place of the circles.
Solid torus(double major, double minor, int around, int across) {
  const auto doubleAreaOfUnitPolygon = [](int corners) {
    return corners * std::sin(2 * std::numbers::pi / corners);
  };
  const double volume = major * doubleAreaOfUnitPolygon(around) * 0.5 * minor * minor *
                        doubleAreaOfUnitPolygon(across);
  return {fixtures::torus(major, minor, around, across), volume, {1}};
}

/// A polyhedron with one surface of genus 0; its volume is summed over the triangles.
Solid ofOneSurface(TriangleMesh mesh) {
  const double volume = signedVolume(mesh);
  return {std::move(mesh), volume, {0}};
}

struct Turn {
  double duration = 1;
  Point3 axisPoint = Point3::Zero();
  Eigen::Vector3d axisDirection = Eigen::Vector3d::UnitZ();
  double angleDegrees = 0;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

ScrewRun runOf(const Turn& turn) {
  return {
      turn.duration, {turn.axisPoint, turn.axisDirection, turn.angleDegrees, turn.translation}, 1};
}

Case meshCase(std::string id, std::string description, Solid solid, std::string motionText,
              std::vector<double> voxelSizes) {
  auto motion = formats::parseMotion(motionText, id);
  assert(motion);
  Case made;
  made.id = std::move(id);
  made.description = std::move(description);
  made.mesh = {std::move(solid.mesh), solid.volume, std::move(solid.genera), std::move(motionText),
               std::move(*motion)};
  made.voxels.voxelSizes = std::move(voxelSizes);
  return made;
}

Case meshCase(std::string id, std::string description, Solid solid, const std::vector<Turn>& turns,
              std::vector<double> voxelSizes) {
  std::vector<ScrewRun> runs;
  runs.reserve(turns.size());
  for (const Turn& turn : turns) runs.push_back(runOf(turn));
  return meshCase(std::move(id), std::move(description), std::move(solid),
                  fixtures::motionText(runs), std::move(voxelSizes));
}

TriangleMesh meshOf(const model::Bounds3& box) {
  TriangleMesh mesh = fixtures::cube(1);
  for (Point3& vertex : mesh.vertices) {
    vertex = box.min + (vertex.array() + 0.5).matrix().cwiseProduct(box.max - box.min);
  }
  return mesh;
}

/// Adds a box whose face at its least x is the first thing that the solid touches. The box moves
/// straight by `translation` during the case.
void addObstacle(Case& to, const model::Bounds3& box, const Eigen::Vector3d& translation,
                 const Point3& touching, double time, double leastSpeed, double depth) {
  const model::TimeSpan span = to.time();
  const ScrewRun run = runOf({.duration = span.end - span.begin, .translation = translation});
  auto motion = model::chainScrews(span.begin, {&run, 1});
  assert(motion);
  auto source = std::make_shared<model::Mesh>();
  const auto swept =
      mesh4d::sweep(meshOf(box), *motion, {.caps = mesh4d::CapMethod::Cone}, *source);
  assert(swept);
  (void)swept;
  const double faceSpeed = translation.x() / (span.end - span.begin);
  to.obstacle = {std::move(source), box.min.x(), faceSpeed, touching, time, leastSpeed, depth};
}

Case fieldCase(Field field, std::function<Surface(double)> surface,
               std::vector<double> voxelSizes) {
  Case made;
  made.fieldSurface = std::move(surface);
  made.id = field.name;
  made.description = field.description;
  made.field = std::move(field);
  made.voxels.voxelSizes = std::move(voxelSizes);
  return made;
}

/// A bound on the surface of a box in which a tool has made a hole or a groove of the given area
/// and of the given integral of curvatures, with edges of the given length that turn by a right
/// angle. The tool's front takes away what is thinner than a voxel's diameter a little early, which
/// counts as an edge about it.
Surface milledSurface(const model::Bounds3& box, double toolRadius, double area, double curved,
                      double edges) {
  const Point3 size = box.max - box.min;
  const double faces = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
  const double front = 4 * std::numbers::pi * toolRadius;
  return {faces + area, curved + std::numbers::sqrt2 * (4 * size.sum() + edges + front)};
}

/// A field that is left of a box by a tool, which goes by `direction` during the case.
Case milledCase(Field field, const model::Bounds3& box, const Surface& surface,
                const mill::ToolShape& tool, const Point3& start, const Eigen::Vector3d& direction,
                std::vector<double> voxelSizes) {
  const ScrewRun run = runOf({.duration = 1, .translation = field.speed * direction});
  auto motion = model::chainScrews(0, {&run, 1});
  assert(motion);
  Case made = fieldCase(
      std::move(field), [=](double) { return surface; }, std::move(voxelSizes));
  made.milling =
      std::make_shared<const Milling>(Milling{meshOf(box), tool, start, std::move(*motion)});
  return made;
}

std::string fixtureMotion(const std::string& name) {
  for (fixtures::NamedMotion& motion : fixtures::allMotions()) {
    if (motion.name == name) return motion.json;
  }
  assert(false);
  return {};
}

/// Table 1 of the paper: the cube of side 20 from section 5.1, which moves by 64 in 64 steps of the
/// mesh, or by one voxel in each of 64 frames of 19 x 19 x 19 points.
Case paperTable() {
  Case made = meshCase("paper-cube", "the cube of the paper's Table 1, translated by one a step",
                       paperCube(), fixtureMotion("paper-translation"), {1});
  made.meshCounts = {4'750, 21'552};
  made.voxels.mask = true;
  made.voxels.maskFrames = 64;
  made.voxels.counts = {197'828, 1'185'280};
  made.visitsVolume = 8000 + 64 * 400;
  made.meanNormalSpeed = 1.0 / 3;  // of two faces of six
  // The surface passes through the midpoints of lattice edges: 18^3 full voxels, 6 x 18^2 halves on
  // the faces, 12 x 18 eighths along the edges and 8 times 1/48 at the corners.
  made.voxels.maskVolume = 5832 + 972 + 27 + 1.0 / 6;
  return made;
}

/// As many triangles as the squirrel of the paper's section 5.2, on the same screw motion. The
/// paper counts 3,909,554 vertices and 18,266,982 cells in 65 steps. By Euler's formula for a
/// surface of genus 0, the squirrel had 10,000 vertices and 19,996 triangles, and TetGen added 102
/// points to each cap.
Case squirrelSize() {
  Case made =
      meshCase("squirrel-size", "a lumpy ball as large as the paper's squirrel, on its screw",
               ofOneSurface(fixtures::pebble(10, 10'000)), fixtureMotion("paper-screw"), {});
  made.minVolumeRatio = 0.9976;
  made.large = true;
  return made;
}

}  // namespace

model::TimeSpan Case::time() const {
  if (mesh) return {mesh->motion.timeBegin(), mesh->motion.timeEnd()};
  return {field->timeBegin, field->timeEnd};
}

double Case::volumeAt(double time) const { return mesh ? mesh->volume : field->volume(time); }

std::optional<double> Case::hypervolume() const {
  if (!mesh) return field->hypervolume;
  const model::TimeSpan span = time();
  return mesh->volume * (span.end - span.begin);
}

std::vector<double> Case::sliceTimes() const {
  const model::TimeSpan span = time();
  // Arbitrary fractions, so that they coincide with no step or frame of any case.
  std::vector<double> times = {span.begin};
  for (const double fraction : {0.1357, 0.3819, 0.5, 0.6423, 0.8781}) {
    times.push_back(span.begin + fraction * (span.end - span.begin));
  }
  times.push_back(span.end);
  return times;
}

std::vector<Case> analyticCases() {
  const std::vector<double> sizes = {2, 1, 0.5};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const auto quarter = [&](const Eigen::Vector3d& axis) {
    return std::vector<Turn>{{.duration = 3, .axisDirection = axis, .angleDegrees = 90}};
  };
  const Turn screw{.duration = 10,
                   .axisPoint = {0, 8, 0},
                   .axisDirection = {1, 0, 0},
                   .angleDegrees = 120,
                   .translation = {9, 0, 0}};
  std::vector<Case> cases;
  cases.push_back(paperTable());
  cases.push_back(meshCase("cube-at-rest", "a cube that does not move", cube(12),
                           std::vector<Turn>{{.duration = 10}}, sizes));
  cases.back().visitsVolume = 12 * 12 * 12;
  cases.back().meanNormalSpeed = 0;
  // The obstacle comes at speed 2, from a distance of 10.
  addObstacle(cases.back(), {Point3(16, -3, -3), Point3(20, 3, 3)}, {-20, 0, 0}, {6, 0, 0}, 5, 2,
              10);
  cases.push_back(meshCase("cube-translated", "a cube along a line", cube(12),
                           std::vector<Turn>{{.duration = 2, .translation = {9, 4, -7}}}, sizes));
  // The cube and its length times its shadow.
  cases.back().visitsVolume = 12 * 12 * 12 + 12 * 12 * (9 + 4 + 7);
  cases.back().meanNormalSpeed = (4.5 + 2 + 3.5) / 3;
  addObstacle(cases.back(), {Point3(9, 0, -4), Point3(11, 2, -2)}, {0, 0, 0}, {6, 0, 0}, 3 / 4.5,
              4.5, 6);
  cases.push_back(meshCase("cube-about-x", "a quarter turn about x", cube(12), quarter(x), sizes));
  cases.push_back(meshCase("cube-about-y", "a quarter turn about y", cube(12), quarter(y), sizes));
  cases.push_back(meshCase("cube-about-z", "a quarter turn about z", cube(12), quarter(z), sizes));
  // An edge of the cube turns into a wall on one side of the axis, at x = 7; at x = 8 it is
  // slowest.
  const double radius = 6 * std::numbers::sqrt2;
  const double perDegree = 3.0 / 90;
  const double speed = model::kRadiansPerDegree / perDegree * std::sqrt(radius * radius - 8 * 8);
  addObstacle(cases.back(), {Point3(7, -20, -20), Point3(11, 0, 20)}, {0, 0, 0}, {6, -6, 0},
              perDegree * (45 - std::acos(7 / radius) * 180 / std::numbers::pi), speed, 1);
  cases.back().obstacle->canGiveWay = true;
  cases.push_back(meshCase("cube-about-skew-axis", "a cube about a skew axis that lies outside it",
                           cube(12),
                           std::vector<Turn>{{.duration = 2,
                                              .axisPoint = {14, -12, 9},
                                              .axisDirection = {1, 2, -2},
                                              .angleDegrees = 50,
                                              .translation = {4, -6, 9}}},
                           sizes));
  cases.push_back(meshCase("cube-screw", "a cube on a screw", cube(12), {screw}, sizes));
  cases.push_back(meshCase("sphere-screw", "a sphere of 1,280 triangles on a screw",
                           ofOneSurface(fixtures::icosphere(7, 3)), {screw}, sizes));
  cases.push_back(
      meshCase("torus-screw", "a torus on a screw", torus(8, 3.5, 48, 24), {screw}, sizes));
  cases.push_back(meshCase("hollow-cube-screw", "a cube with a cavity on a screw",
                           hollowCube(16, 8), {screw}, sizes));
  cases.push_back(meshCase("segments", "five segments: turns about three axes, a shift, a rest",
                           cube(12),
                           {{.duration = 2, .angleDegrees = 90},
                            {.duration = 1, .translation = {7, 0, 0}},
                            {.duration = 0.5},
                            {.duration = 2,
                             .axisPoint = {7, 0, -5},
                             .axisDirection = y,
                             .angleDegrees = -60,
                             .translation = {0, 4, 0}},
                            {.duration = 1.5, .axisDirection = {1, 1, 0}, .angleDegrees = 40}},
                           sizes));
  cases.push_back(squirrelSize());
  const auto sphere = [](double radius) {
    return Surface{4 * std::numbers::pi * radius * radius, 8 * std::numbers::pi * radius};
  };
  cases.push_back(fieldCase(
      fixtures::growingSphere(3, 9), [=](double t) { return sphere(3 + 6 * t); }, sizes));
  // Masks of solids that move by 3 voxels from frame to frame.
  const auto addMasks = [&](const fixtures::Field& solid, const Surface& surface, double order) {
    cases.push_back(fieldCase(
        solid, [=](double) { return surface; }, sizes));
    cases.back().id += "-mask";
    cases.back().description += ", in masks 3 voxels apart";
    cases.back().voxels.maskMotion = 3;
    cases.back().voxels.order = order;
  };
  addMasks(fixtures::growingSphere(6, 18), sphere(18), 2);
  addMasks(fixtures::translatingSphere(12, {13, 9, -5}), sphere(12), 2);
  // Its faces lie on the lattice in the first and the last frame, and are half a voxel too low.
  addMasks(fixtures::rotatingCube(20), {2400, 240 * std::numbers::sqrt2}, 1);
  cases.push_back(fieldCase(
      fixtures::pulsatingSphere(9),
      [=](double t) { return sphere(std::max(0.0, 9 * (1 - 4 * (t - 0.5) * (t - 0.5)))); }, sizes));
  cases.push_back(fieldCase(
      fixtures::mergingSpheres(8),
      [=](double) {
        // The crease between them is at most a great circle, where the normal turns by at most 2;
        // where they are about to touch, the gap is narrower than a voxel's diameter on a disc of
        // no more than half that.
        const Surface one = sphere(8);
        return Surface{2 * one.area, 2 * one.bending + 1.5 * 2 * (2 * std::numbers::pi * 8)};
      },
      sizes));
  // Half as far apart as when they touch, they are 1 / sqrt(8) later.
  const double touch = std::sqrt(0.125);
  cases.back().events = {{TrackEventKind::Merges, 0.5 - touch, 4 / touch, 4},
                         {TrackEventKind::Splits, 0.5 + touch, 4 / touch, 4}};
  cases.back().tracks = 5;
  cases.push_back(fieldCase(
      fixtures::closingTorus(8),
      [=](double t) {
        // An upper bound: the torus intersects itself, and the part inside is counted as well. The
        // curvatures are 1 / minor and cos(v) / (major + minor cos(v)).
        constexpr double kPi = std::numbers::pi;
        const double major = 8;
        const double minor = major * (0.4 + t);
        return Surface{4 * kPi * kPi * major * minor, 4 * kPi * kPi * major + 8 * kPi * minor};
      },
      sizes));
  cases.back().events = {{TrackEventKind::HoleCloses, 0.6, 8, 3.2}};
  cases.push_back(fieldCase(
      fixtures::openingCavity(11, 4, {26.0 / 3, 13.0 / 3, 26.0 / 3}),
      [=](double) {
        // The crease where it has opened is at most a great circle of the cavity, as is where the
        // wall is thinner than a voxel's diameter.
        const Surface outer = sphere(11);
        const Surface inner = sphere(4);
        return Surface{outer.area + inner.area,
                       outer.bending + inner.bending + 1.5 * 2 * (2 * std::numbers::pi * 4)};
      },
      sizes));
  // The wall, 7 thick at the start, gets thinner at speed 13 between two sheets.
  cases.back().events = {{TrackEventKind::CavityOpens, 7.0 / 13, 13.0 / 2, 6.0 / 2}};
  constexpr double kPi = std::numbers::pi;
  const model::Bounds3 plate{{-9.3, -8.2, 0.1}, {9.2, 8.8, 6.1}};
  const double ball = 4;
  const double thickness = plate.max.z() - plate.min.z();
  cases.push_back(milledCase(fixtures::drilledPlate(plate, ball), plate,
                             milledSurface(plate, ball, 2 * kPi * ball * (thickness + ball),
                                           2 * kPi * thickness + 4 * kPi * ball, 4 * kPi * ball),
                             {mill::ToolKind::Ball, 2 * ball, 0, 40}, {0, 0, plate.max.z() + 1}, -z,
                             sizes));
  const model::Bounds3 block{{-8.3, -8.2, 0.1}, {8.2, 8.8, 6.1}};
  const double flat = 3;
  const double height = block.max.z() - block.min.z();
  const double length = block.max.x() - block.min.x();
  cases.push_back(milledCase(fixtures::partedBlock(block, flat), block,
                             milledSurface(block, flat, height * (2 * length + kPi * flat),
                                           kPi * height, 4 * length + 2 * kPi * flat + 4 * height),
                             {mill::ToolKind::Flat, 2 * flat, 0, 40},
                             {block.min.x() - flat - 1, 0, -1}, x, sizes));
  // The tool's front goes from one before the block to the face behind, at one speed.
  const double forward = cases.back().field->speed;
  cases.back().events = {{TrackEventKind::Splits, (length + 1) / forward, forward / 2, flat}};
  cases.back().tracks = 3;
  return cases;
}

}  // namespace t4d::conformance
