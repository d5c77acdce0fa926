#pragma once

/// Tests of programs that make 4D meshes, against closed forms.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

/// Verifies a 4D mesh against its closed form. Each check states the expected and the actual value,
/// the tolerance, and the reason for it.
namespace t4d::conformance {

/// A property, a count, or a measure.
using Value = std::variant<bool, std::uint64_t, double>;

struct Check {
  std::string name;
  Value expected;
  Value actual;
  double tolerance = 0;  ///< the maximum difference, in the unit of the values
  std::string reason;    ///< why the tolerance is what it is: rounding, order of convergence, ...
  bool passed = false;
  std::string found;  ///< for a failed check: what is wrong, if more is known than the numbers
};

/// Each of these functions returns a check with `passed` set.
Check holds(std::string name, bool expected, bool actual, std::string reason,
            std::string found = {});
Check countIs(std::string name, std::uint64_t expected, std::uint64_t actual, std::string reason,
              std::string found = {});

/// A number and its tolerance.
struct Measure {
  double value = 0;
  double tolerance = 0;
  std::string reason;
};

Check measureIs(std::string name, const Measure& expected, double actual);

/// Location of a surface.
struct SurfaceExpectation {
  std::function<double(const model::Point3&)> distance;  ///< from a point; of either sign
  double tolerance = 0;  ///< the maximum distance of a vertex of the slice
  std::string reason;
};

/// Expected properties of the solid at one time.
struct SliceExpectation {
  double time = 0;
  std::optional<Measure> volume;
  std::optional<SurfaceExpectation> surface;
  /// The genus of each of its surfaces, in descending order; a cavity has a surface of its own.
  std::optional<std::vector<int>> genera;
};

struct Counts {
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
};

/// The box that the moving solid fills, over all times.
struct BoundsExpectation {
  model::Bounds3 box;
  double tolerance = 0;  ///< for each of the six faces, in length units
  std::string reason;
};

/// The first contact of the solid with another one.
struct ContactExpectation {
  std::shared_ptr<const model::Source> obstacle;
  Measure time;
  /// Whether the mesh can be moved out of the way of the obstacle with edit::resolve.
  bool canGiveWay = false;
};

/// A change of the solid's topology.
struct EventExpectation {
  measure::TrackEventKind kind = measure::TrackEventKind::Merges;
  Measure time;
};

/// The components of the solid over time (measure::tracksOf).
struct TracksExpectation {
  std::uint64_t tracks = 0;  ///< number of components, from birth to death
  /// Events in the order of time. If there are any, other kinds of events are not checked: where a
  /// wall is thinner than a voxel, holes may open and close.
  std::vector<EventExpectation> events;
};

/// Expected properties of a 4D mesh.
struct Expectation {
  Measure timeBegin;
  Measure timeEnd;
  std::optional<Measure> hypervolume;
  std::optional<BoundsExpectation> bounds;
  /// The integral over space of the number of visits to each point (measure::Silhouette).
  std::optional<Measure> visitsVolume;
  /// measure::meanNormalSpeed, the time scale of the quality of cells.
  std::optional<Measure> meanNormalSpeed;
  std::optional<ContactExpectation> contact;
  std::optional<TracksExpectation> tracks;
  std::vector<SliceExpectation> slices;
  std::optional<Counts> counts;
  std::optional<Counts> sideCounts;  ///< without the slabs that close the ends (no thickness)
  std::string countsReason;
  /// The links of inner cap vertices are spheres too. A cone over a torus, for example, cannot
  /// satisfy this; hypervolume and slices are not affected.
  bool manifoldCaps = true;
};

struct MeshResult {
  std::vector<Check> checks;
  double hypervolume = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::vector<std::optional<double>> sliceVolumes;  ///< one per slice of the expectation

  bool passed() const;
};

/// Checks that the mesh is valid (each slab, and the seams between them), closed, consistently
/// oriented, a manifold, and without degenerate cells; then that it matches `expectation`. If a
/// slab cannot be read or is invalid, that check is the last one.
///
/// Reads every slab once, and once more for each slice and each of the other properties.
MeshResult verify(const model::Source& mesh, const Expectation& expectation,
                  const model::Progress& progress = {});

}  // namespace t4d::conformance

/// Moving solids as functions of space and time.
namespace t4d::fixtures {

/// The topology of a solid at one time: its connected surfaces, of which a cavity has one of its
/// own, and the total number of handles.
struct Topology {
  double time = 0;
  int components = 0;
  int genus = 0;
};

/// A moving solid: the points where `value` is negative.
struct Field {
  std::string name;
  std::string description;
  std::function<double(const model::Point3& point, double time)> value;
  model::Bounds3 box;  ///< contains the solid at all times, with a margin
  double timeBegin = 0;
  double timeEnd = 1;
  double slope = 1;                           ///< Lipschitz constant in space; 0: unbounded
  double speed = 0;                           ///< Lipschitz constant in time; 0: unknown
  std::function<double(double time)> volume;  ///< empty if no closed form is known
  std::optional<double> hypervolume;          ///< from timeBegin to timeEnd
  std::vector<Topology> topology;             ///< at selected times
};

}  // namespace t4d::fixtures

/// Moving solids whose relevant properties are known in closed form.
namespace t4d::conformance {

/// A solid bounded by a triangle mesh, and how it moves.
struct MovingMesh {
  model::TriangleMesh mesh;
  double volume = 0;        ///< of the solid, in closed form if there is one
  std::vector<int> genera;  ///< of its surfaces, in descending order
  std::string motionText;   ///< the text of a motion file (docs/motion.md)
  model::Motion motion;     ///< the same motion, parsed
};

/// A change of a solid's topology at a known time.
struct TopologyEvent {
  measure::TrackEventKind kind = measure::TrackEventKind::Merges;
  double time = 0;
  /// How fast two sheets of the surface approach or leave each other there, at least until they are
  /// `depth` from where they meet.
  double leastSpeed = 0;
  double depth = 0;
};

/// A box whose face at its smallest x the moving solid first touches at a known time.
struct Obstacle {
  std::shared_ptr<const model::Source> source;
  double faceX = 0;        ///< at the start
  double faceSpeed = 0;    ///< along x
  model::Point3 touching;  ///< the point of the solid that touches first, at the start
  double time = 0;         ///< of the first contact
  /// The point moves towards the face at least at this speed until it is `depth` behind the face.
  double leastSpeed = 0;
  double depth = 0;
  bool canGiveWay = false;  ///< whether edit::resolve can move the swept solid out of the way
};

/// The way in which voxel4d runs a case.
struct VoxelPlan {
  /// Sizes of voxels in length units, each half of the one before. Empty if voxel4d does not run
  /// the case.
  std::vector<double> voxelSizes;
  /// Store the lattice points inside instead of distances, with one frame per unit of time and a
  /// single voxel size.
  bool mask = false;
  std::size_t maskFrames = 0;
  double maskVolume = 0;         ///< volume of the slice at each frame
  std::optional<Counts> counts;  ///< if known
  /// For a field: store the lattice points inside instead of distances, with frames between which
  /// its surface moves by this many voxels. 0 stores distances.
  double maskMotion = 0;
  double order = 2;  ///< of convergence, when voxels and the time between frames are halved
};

/// Properties of a surface that determine the voxel error.
struct Surface {
  double area = 0;
  /// The sum over all edges of length times |difference of the two normals|; where the surface is
  /// smooth, the integral of the sum of the two principal curvatures, both taken positive.
  double bending = 0;
};

struct Milling;

struct Case {
  std::string id;
  std::string description;
  /// The moving solid: exactly one of these two is set.
  std::optional<MovingMesh> mesh;
  std::optional<fixtures::Field> field;
  /// Surface of the field at a time; an upper bound if there is no single formula.
  std::function<Surface(double time)> fieldSurface;
  std::shared_ptr<const Milling> milling;  ///< how a tool makes the field, if one can
  /// The integral over space of the number of visits to each point, for solids that rest or move
  /// along a straight line.
  std::optional<double> visitsVolume;
  /// The mean over the surface of its speed along its normal, for solids that rest or move along a
  /// straight line.
  std::optional<double> meanNormalSpeed;
  std::optional<Obstacle> obstacle;  ///< of a mesh
  /// Changes of the topology of a field, in the order of time, if known, and the number of its
  /// components from birth to death. A mesh in rigid motion has no changes.
  std::vector<TopologyEvent> events;
  std::uint64_t tracks = 1;
  /// R_Vmin for mesh4d (mesh4d/steps.h).
  double minVolumeRatio = 0.998;
  /// Counts for mesh4d with TetGen caps, if the total is known.
  std::optional<Counts> meshCounts;
  VoxelPlan voxels;
  bool large = false;  ///< skipped in a quick run

  model::TimeSpan time() const;
  double volumeAt(double time) const;
  std::optional<double> hypervolume() const;
  /// The times at which the oracle slices: both ends, and times at odd fractions between them.
  std::vector<double> sliceTimes() const;
};

/// All cases, in listing order. Ids are words joined by hyphens.
std::vector<Case> analyticCases();

}  // namespace t4d::conformance

/// The closed form of a case for each way of making its 4D mesh, and the tolerances, all of which
/// are derived here.
namespace t4d::conformance {

/// A mesh swept in steps (mesh4d). For any closed mesh, any axis and any translation, the slice at
/// fraction s of a step that turns by theta has exactly the volume
/// V0 (1 - 2 s (1 - s) (1 - cos theta)), so a step of duration dt encloses
/// V0 dt (2 + cos theta) / 3. Tolerances cover rounding only. With `cones` the ends are closed by
/// cones, not by TetGen.
Result<Expectation> sweptExpectation(const Case& given, bool cones);

/// Voxel size and number of frames, refined together.
struct Resolution {
  double voxelSize = 0;     ///< 0 if the backend has no voxels
  std::uint64_t steps = 0;  ///< intervals between frames; 0 if the backend has no voxels
};

/// The voxel sizes of the case, each with enough frames that nothing moves by more than a voxel
/// between two of them, or by VoxelPlan::maskMotion voxels.
std::vector<Resolution> voxelResolutions(const Case& given);

/// A mesh woven from voxels (voxel4d): the true solid, within the error of interpolating the
/// distance linearly in cells of diameter D, D^2 = 3 h^2 + (motion between two frames)^2:
///
/// * Across an edge of the solid the distance has a kink. There a linear interpolation is off by at
///   most |difference of normals| D / 4, on a strip at most 2 D wide, and by half of that on
///   average: a volume of bending D^2 / 4. On a smooth surface, half of this volume bounds the
///   interpolation error in space; acceleration adds less than the other half.
/// * Faces that turn by an angle a between two frames make the distance bilinear in space and time:
///   the error is at most a h sqrt(3) / 4, and along the arc a h / 8.
/// * Vertices are kept a thousandth of a voxel off the lattice (voxel4d::kOffLattice), which moves
///   a face on the lattice by as much.
/// * The surface of a mask, and so the distance from it, is off by at most half a voxel's diagonal.
///
/// Each vertex of a slice shares its cell with a point inside and one outside, so its distance from
/// the surface is at most the diagonal of a voxel plus the motion between two frames.
Expectation voxelExpectation(const Case& given, const Resolution& resolution);

/// The paper's mask frames; requires `voxels.mask`.
Expectation maskExpectation(const Case& given);

/// The true solid of a mesh case, within a relative tolerance, for a backend whose method is
/// unknown. It may close the ends by cones.
Expectation solidExpectation(const Case& given, double relativeTolerance);

/// Makes 4D meshes of moving solids. To test your own backend, implement this interface and pass it
/// to `runCase`.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual bool supports(const Case& given) const = 0;

  /// The resolutions to test, coarse to fine; a single default one if the backend has nothing to
  /// refine.
  virtual std::vector<Resolution> resolutions(const Case& given) const {
    (void)given;
    return {{}};
  }
  /// The closed form for the mesh, with tolerances.
  virtual Result<Expectation> expectation(const Case& given,
                                          const Resolution& resolution) const = 0;
  /// Builds the mesh.
  virtual Result<void> build(const Case& given, const Resolution& resolution,
                             model::Sink& sink) const = 0;
};

/// The result of a case at one resolution.
struct Level {
  Resolution resolution;
  MeshResult mesh;
  std::optional<double> hypervolumeError;  ///< |found - true| / true, if the true one is known
  std::optional<double> sliceError;        ///< the root mean square of this over slices
};

/// Orders of convergence: the powers of the voxel size with which errors fall.
struct Orders {
  std::optional<double> hypervolume;
  std::optional<double> slices;
};

struct CaseResult {
  std::string id;
  std::string description;
  std::string backend;
  std::vector<Check> checks;  ///< of all levels, and of the orders
  std::vector<Level> levels;
  std::optional<double> hypervolumeExpected;  ///< at the finest level
  std::optional<double> worstError;           ///< relative, of any volume at the finest level
  Orders orders;
  double seconds = 0;

  bool passed() const;
  std::size_t passedChecks() const;
};

/// Builds the case at each resolution and verifies the meshes. `quick` skips the finest resolution
/// if there are more than two. A backend that returns an error fails the check "made".
///
/// Errors should fall with the square of the voxel size h (expectations.h), so order 2 is expected
/// between the coarsest and the finest, or VoxelPlan::order. For masks, only the order of slices is
/// checked. The constant before h^2 depends on the position of the surface on the lattice; the
/// tolerance allows it to change by a factor of two.
CaseResult runCase(const Case& given, const Backend& backend, bool quick,
                   const model::Progress& progress = {});

struct Job {
  const Case* given = nullptr;
  const Backend* backend = nullptr;
};

/// Runs several cases in parallel. The results are in the order of the jobs and, except for the
/// seconds, the same for any number of threads. `finished` is called after each case, never
/// concurrently.
std::vector<CaseResult> runCases(std::span<const Job> jobs, bool quick,
                                 const std::function<void(const CaseResult&)>& finished = {});

}  // namespace t4d::conformance
