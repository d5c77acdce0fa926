#pragma once

/// What a 4D mesh is: whether it is valid, how large it and its slices are, how it differs from
/// another, what becomes of its components, what shape its cells have. have.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::measure {

enum class Severity : std::uint8_t { Error = 0, Warning = 1, Information = 2, Hint = 3 };

/// One finding. `code` is one of those listed in docs/validate.md and never changes its meaning.
struct Issue {
  std::string code;
  Severity severity = Severity::Error;
  std::string message;                  ///< names the cell, facet or vertex
  std::optional<std::uint64_t> slab;    ///< counted from 0
  std::optional<std::uint64_t> offset;  ///< byte offset, if the slab comes from a file
};

/// Findings. All are counted; the first kKeptOfEachCode of each code are kept.
struct IssueList {
  static constexpr std::uint64_t kKeptOfEachCode = 10;

  std::uint64_t errors = 0;
  std::uint64_t warnings = 0;
  std::vector<Issue> issues;

  void add(Issue issue);
  /// `count` findings of one kind, of which `issue` is the first.
  void add(Issue issue, std::uint64_t count);
  /// Findings of the slabs that follow.
  void add(const IssueList& after);

 private:
  std::map<std::string, std::uint64_t> kept_;
};

/// Result of checking a whole 4D mesh.
struct MeshReport {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;  ///< each counted once, even if two slabs have it
  std::uint64_t tetrahedra = 0;
  model::TimeSpan time;
  model::Bounds4 bounds;

  bool closed = true;         ///< every facet has exactly two cells
  bool oriented = true;       ///< on opposite sides
  double hypervolume = 0;     ///< enclosed, in length^3 * time; the sum of det[a,b,c,d]/24
  double boundaryVolume = 0;  ///< 3-measure of all cells, taking one time unit as one length unit
  std::uint64_t components = 0;
  std::uint64_t degenerateCells = 0;
  std::optional<bool> vertexLinksOk;  ///< with CheckOptions::vertexLinks

  IssueList issues;

  bool valid() const { return issues.errors == 0; }
};

struct CheckOptions {
  bool vertexLinks = false;  ///< the deep check: every vertex is manifold
  /// The slabs are a part of a mesh, which goes on before the first or after the last of them: that
  /// layer is open, and what they enclose may be negative.
  bool goesOnBefore = false;
  bool goesOnAfter = false;
};

struct PartOfMesh;

/// Checks and measures a 4D mesh slab by slab, with two in memory: that each slab is valid on its
/// own (checkSlab), that layers are equal (`==`) across seams, that the mesh is closed and oriented
/// and, on request, that it is manifold at every vertex. Checks that depend on the connectivity
/// alone are done once for consecutive slabs that share it.
///
/// Findings do not stop the check; `put` fails only for a slab that cannot be checked at all.
class MeshChecker : public model::Sink {
 public:
  explicit MeshChecker(CheckOptions options = {});
  ~MeshChecker() override;

  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;

  /// Call it before the first slab of a part: `slab` is the one before it, which has this number,
  /// and is not counted. The layer between them is checked, and slabs have their numbers in the
  /// mesh.
  Result<void> startAfter(const model::Slab& slab, std::uint64_t number);

  /// The report. Call it once, after the last slab.
  MeshReport finish();
  /// The report on a part of the mesh (mesh_parts.h). Call it once, in place of `finish`. If
  /// startAfter was called, CheckOptions::goesOnBefore must be set.
  PartOfMesh finishPart();

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// Checks all slabs of a source.
Result<MeshReport> checkMesh(const model::Source& source, CheckOptions options = {},
                             const model::Progress& progress = {});

/// Measures of a solid at one time, in length units; exact except for rounding. All are 0 if there
/// is no solid.
struct SolidMeasures {
  double time = 0;
  double volume = 0;
  double area = 0;
  model::Point3 centroid = model::Point3::Zero();
  std::uint64_t components = 0;  ///< connected surfaces that face outward
  std::uint64_t cavities = 0;    ///< those that face inward
  /// The number of handles: the sum of the genera of all surfaces (generaOf).
  double genus = 0;
  model::Bounds3 bounds = {};  ///< empty() of nothing

  /// Adds another solid at the same time, which counts as apart from this one.
  void add(const SolidMeasures& other);
};

/// Measures a closed triangle mesh that faces outward; `time` is 0.
SolidMeasures measuresOf(const model::TriangleMesh& mesh);

/// Measures each body at each of `times`, which may be in any order; all is 0 when it does not
/// exist. Several times are sliced at once, one on each thread, which has a slab in memory. Fails
/// for a time before the first body or after the last, for a slice that is not closed, and if
/// slicing does.
Result<std::vector<std::vector<SolidMeasures>>> measuresOfEach(
    std::span<const model::Body> bodies, std::span<const double> times,
    const model::Progress& progress = {});

/// Adds up the measures of several bodies at the same times (SolidMeasures::add).
std::vector<SolidMeasures> addedUp(std::span<const std::vector<SolidMeasures>> bodies);

/// Measures all bodies that exist at each of `times` as one solid: measuresOfEach, then addedUp.
Result<std::vector<SolidMeasures>> measuresAt(std::span<const model::Body> bodies,
                                              std::span<const double> times,
                                              const model::Progress& progress = {});

/// The shape of a tetrahedron in R^4, measured within its own three dimensions. The best
/// tetrahedron is the regular one; what each measure is of it stands in brackets. A flat cell has
/// infinite ratios, angles of 0 and 180 degrees and no height.
struct CellQuality {
  double volume = 0;         ///< 3-measure, in length^3
  double edgeRatio = 0;      ///< longest edge divided by the shortest [1]
  double radiusRatio = 0;    ///< radius of the circumsphere, divided by three inradii [1]
  double smallestAngle = 0;  ///< between two sides, in degrees [70.53]
  double largestAngle = 0;   ///< between two sides, in degrees [70.53]
  double height = 0;         ///< the smallest height, divided by the longest edge [0.8165]
};

/// Measures a tetrahedron after its times have been multiplied by `timeScale`, a length for each
/// unit of time.
CellQuality qualityOf(const std::array<model::Point4, 4>& corners, double timeScale);

/// A member of CellQuality.
struct QualityMeasure {
  std::string_view name;  ///< as in JSON and for attributes
  double CellQuality::*value;
};
inline constexpr std::array<QualityMeasure, 6> kQualityMeasures = {
    {{"volume", &CellQuality::volume},
     {"edge_ratio", &CellQuality::edgeRatio},
     {"radius_ratio", &CellQuality::radiusRatio},
     {"smallest_angle", &CellQuality::smallestAngle},
     {"largest_angle", &CellQuality::largestAngle},
     {"height", &CellQuality::height}}};

/// A histogram of the values of a measure over cells. Values are counted in bins of 0.4 per cent,
/// so the memory is that of the powers of two between them, for any number of cells.
class Distribution {
 public:
  Distribution();

  /// `value` is not negative and may be infinite; what is below 2^-1022 counts as 0.
  void add(double value, std::uint64_t count = 1);
  void add(const Distribution& other);

  std::uint64_t count() const { return count_; }
  double min() const { return min_; }  ///< exact; 0 without cells
  double max() const { return max_; }  ///< exact; 0 without cells
  /// The value that the given fraction of the cells does not exceed, to 0.2 per cent.
  double quantile(double fraction) const;
  /// The number of values between consecutive `edges`, which increase; to 0.2 per cent of the
  /// value.
  std::vector<std::uint64_t> histogram(const std::vector<double>& edges) const;
  /// The counts of one bin; `of` makes a distribution from bins again.
  struct Bin {
    std::uint32_t number = 0;
    std::uint64_t count = 0;
  };
  std::vector<Bin> bins() const;
  /// Returns nothing if there are no such bins.
  static std::optional<Distribution> of(const std::vector<Bin>& bins, double min, double max);

  /// The distribution of the values that are neither 0 nor infinite, each to 0.2 per cent.
  Distribution positiveAndFinite() const;

 private:
  /// Calls visit(value, count) for each bin that counts something, in ascending order, until it
  /// returns false.
  template <class Visit>
  void eachBin(Visit visit) const;

  /// The bins of all values with the same exponent; empty where there are none.
  std::vector<std::vector<std::uint64_t>> octaves_;
  std::uint64_t count_ = 0;
  double min_ = 0;
  double max_ = 0;
};

/// A cell and where it is.
struct RankedCell {
  std::size_t body = 0;
  std::uint64_t slab = 0;                        ///< of the body
  std::uint64_t cell = 0;                        ///< of the slab
  model::Point4 center = model::Point4::Zero();  ///< mean of its corners
  CellQuality quality;
};

/// The shape of the cells of a 4D mesh.
struct MeshQuality {
  double timeScale = 0;
  /// The distribution of each measure in kQualityMeasures over the cells of slabs that last, and
  /// over those of caps.
  std::array<Distribution, kQualityMeasures.size()> sides;
  std::array<Distribution, kQualityMeasures.size()> caps;
  std::uint64_t flat = 0;         ///< cells without volume
  std::vector<RankedCell> worst;  ///< the largest radius ratios, the largest first

  std::uint64_t cells() const { return sides[0].count() + caps[0].count(); }
  Distribution all(std::size_t measure) const;
};

/// How fast the surface of the bodies moves along its normal, in the mean over its area and time:
/// the integral of |n_t| over all cells that last, divided by that of |(n_x, n_y, n_z)|. 0 for
/// bodies at rest.
Result<double> meanNormalSpeed(std::span<const model::Body> bodies,
                               const model::Progress& progress = {});

struct QualityOptions {
  double timeScale = 1;    ///< a length for each unit of time; positive
  std::size_t worst = 10;  ///< how many cells to name
};

/// Measures all cells, slab by slab, on all threads; the result does not depend on their number.
Result<MeshQuality> measureQuality(std::span<const model::Body> bodies,
                                   const QualityOptions& options,
                                   const model::Progress& progress = {});

/// Adds attributes of cells for each of `measures`, as float32, and passes slabs on. Attributes
/// that have their names are replaced.
class QualitySink : public model::Sink {
 public:
  /// `measures` and `next` must outlive the sink.
  QualitySink(std::span<const QualityMeasure> measures, double timeScale, model::Sink& next)
      : measures_(measures), timeScale_(timeScale), next_(next) {}

  Result<void> put(const model::Slab& slab) override;

  /// The names of attributes that were replaced.
  const std::set<std::string>& replaced() const { return replaced_; }

 private:
  void dropNamed(std::vector<model::Attribute>& attributes);

  std::span<const QualityMeasure> measures_;
  double timeScale_;
  model::Sink& next_;
  std::set<std::string> replaced_;
  // The last connectivity, and it without attributes that are replaced.
  std::shared_ptr<const model::Connectivity> given_;
  std::shared_ptr<const model::Connectivity> kept_;
};

/// The distance between two surfaces, in length units.
struct SurfaceDistance {
  /// The largest distance of a point of A from B, and of a point of B from A; both may be too small
  /// by up to `tolerance`.
  double fromA = 0;
  double fromB = 0;
  double tolerance = 0;

  /// The Hausdorff distance.
  double hausdorff() const { return std::max(fromA, fromB); }
};

/// The two one-sided distances of triangle meshes as sets of points, ignoring vertices without a
/// triangle. `relativeTolerance` > 0 is a fraction of the diagonal of the bounds of both.
///
/// Distances of points are exact (TriangleTree). A triangle is halved as long as it may contain a
/// point that is farther than the farthest found so far by more than the tolerance. The bound: the
/// distance from one triangle of the other mesh is convex, so its maximum over a piece is at a
/// corner, and it is not less than the distance from the whole mesh. Identical surfaces give 0.
///
/// Infinite, with tolerance 0, if exactly one mesh is empty; 0 if both are.
SurfaceDistance surfaceDistance(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                double relativeTolerance = 1e-3);

/// An upper bound of the distance of all points of `a` from `b`, too large by no more than a
/// fraction of the diagonal of the bounds of both. Neither may be empty.
double farthestFrom(const model::TriangleMesh& a, const model::TriangleMesh& b,
                    double relativeTolerance = 1e-3);

/// The distance of some point of one surface from the other that is more than `distance`; nothing
/// if there is none, but for points farther by less than a thousandth of it. Much faster than
/// surfaceDistance where the answer is clear: infinite if exactly one mesh is empty.
///
/// Fails if it takes more than some million steps, as for surfaces that lie on one another, in
/// other triangles, and a `distance` that is many times smaller than these.
Result<std::optional<double>> fartherThan(double distance, const model::TriangleMesh& a,
                                          const model::TriangleMesh& b);

struct SolidDifferenceOptions {
  /// Lines along the longer side of each lattice; at least 4.
  std::uint32_t resolution = 256;
};

struct SolidDifference {
  double volume = 0;  ///< of what is asked for, in cubic length units
  double error = 0;   ///< estimate of its error
};

/// The volume of the points that lie in one solid and not in the other, for solids bounded by
/// closed triangle meshes: the integral of |w_a - w_b|, where w is the winding number of a surface
/// about a point. For surfaces that do not intersect themselves w is 1 inside and 0 outside. If
/// they do, parts count as often as they do in signedVolume, so that |V_a - V_b| <= volume always
/// holds, and no part makes the function fail.
///
/// The result is the mean of integrals along four square lattices of parallel lines, exact on each
/// line and by the midpoint rule across, each lattice spanning the bounds of both; parts whose
/// bounds are apart get lattices of their own. The lines are askew to the axes, since solids often
/// have faces along those: then the integrand is continuous, and the error falls with the square of
/// the spacing. `error` is twice the largest deviation of the four from their mean: an estimate,
/// which is too small for about one pair of solids in fifty. Surfaces that consist of the same
/// triangles, in any order, give exactly 0.
///
/// Fails for a mesh that is not closed.
Result<SolidDifference> solidDifference(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                        const SolidDifferenceOptions& options = {});

/// The volume of the points that lie in both solids: the integral of min(w_a, w_b) where that is
/// positive, in the same way, but the lattices span what the solids have in common
/// (common_parts.h): the error is a fraction of the volume, however small it is. Solids whose
/// interiors have no common point give 0 up to rounding.
Result<SolidDifference> solidOverlap(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                     const SolidDifferenceOptions& options = {});

}  // namespace t4d::measure

/// Compares two 4D meshes by the solids they represent at given times.
namespace t4d::measure {

struct CompareOptions {
  SolidDifferenceOptions difference = {};
  double distanceTolerance = 1e-3;  ///< for surfaceDistance
};

/// Two solids at one time; a solid that does not exist then is empty.
struct SliceComparison {
  double time = 0;
  double volumeA = 0;
  double volumeB = 0;
  double areaA = 0;
  double areaB = 0;
  SolidDifference difference;
  SurfaceDistance distance;
};

/// The solid of all bodies that exist at a time, as one closed mesh without attributes; empty if
/// none does. Fails if slicing does.
Result<model::TriangleMesh> solidAt(std::span<const model::Body> bodies, double time);

/// Fails if solidDifference does.
Result<SliceComparison> compareSolids(double time, const model::TriangleMesh& a,
                                      const model::TriangleMesh& b,
                                      const CompareOptions& options = {});

/// Compares the solids at each time, one on each thread, which has two slabs and two slices in
/// memory.
Result<std::vector<SliceComparison>> compareAt(std::span<const model::Body> a,
                                               std::span<const model::Body> b,
                                               std::span<const double> times,
                                               const CompareOptions& options = {},
                                               const model::Progress& progress = {});

/// `count` times from the first to the last of `span`, as evenly spaced as goes without a beat: the
/// slices of a sweep are smallest half way between two layers, so times that fall now on a layer
/// and now between two would make a zigzag of a constant volume. Each time but the first and the
/// last is moved to the middle of the longest step of the bodies that it falls into, unless that
/// step has four times or more, which show what happens in it. Times that are then the same are
/// one, so there may be fewer.
std::vector<double> timesAmidSteps(std::span<const model::Body> bodies, const model::TimeSpan& span,
                                   std::uint64_t count);

/// The number of `times` that fall within some body, and on a layer or an end of every body that
/// exists then. If all do, the comparison says nothing about the time between layers.
std::size_t timesOnLayers(std::span<const model::Body> bodies, std::span<const double> times);

}  // namespace t4d::measure

/// The components of a solid over time: when each appears, splits, merges and vanishes.
///
/// The slice of a closed mesh at a time is a set of closed surfaces. Between two times at which
/// the mesh has vertices they move and change their shape, but not their number, their Euler
/// numbers or which is within which. So every change has the exact time of vertices of the mesh,
/// which is taken as it is, straight between layers. A change is found by comparing the slice just
/// before a time with the slice just after it; all vertices of one time count together, and the
/// surfaces that the slice at that time connects are one change (SlabReeb).
///
/// A component of the solid is what an outward surface encloses, less the cavities in it, whose
/// surfaces face inward. A track is a component from the time at which it appears, or comes out of
/// a split or a merger, to the time at which it vanishes, splits or merges. It keeps its number
/// while holes and cavities open and close in it. Those that exist at the first time of the mesh
/// begin with it, however they came to be, and those that exist at the last time end with it:
/// neither is an event.
namespace t4d::measure {

enum class TrackEventKind : std::uint8_t {
  Appears,         ///< none before, one or more after
  Vanishes,        ///< one or more before, none after
  Splits,          ///< one before, several after
  Merges,          ///< several before, one after
  Rearranges,      ///< several before, several after
  HoleOpens,       ///< a surface has a handle more: its genus rises by `count`
  HoleCloses,      ///< it falls by `count`
  CavityAppears,   ///< cavities begin within the solid
  CavityVanishes,  ///< they are filled
  CavityOpens,     ///< they are connected to the outside or to a cavity around the solid
  CavityCloses,    ///< they are cut off from it
  CavitiesSplit,   ///< there are `count` more, out of others
  CavitiesMerge,   ///< there are `count` less
};

/// An event: a change of components at one time and place.
struct TrackEvent {
  double time = 0;
  TrackEventKind kind = TrackEventKind::Appears;
  /// The mean of the vertices of the mesh where the topology changes.
  model::Point3 place = model::Point3::Zero();
  std::vector<std::uint32_t> before = {};  ///< tracks that take part, as they were before
  std::vector<std::uint32_t> after = {};
  /// The number of holes or cavities; for other kinds, the difference of the numbers of tracks.
  std::uint64_t count = 0;
  /// The change of the Euler number of the slice.
  std::int64_t euler = 0;
};

struct TrackSample {
  SolidMeasures measures;
  /// The distance from the centroid of the previous sample, divided by the time between them; the
  /// first sample has none.
  std::optional<double> speed = {};
};

struct Track {
  double begin = 0;
  double end = 0;
  bool beginsWithMesh = false;
  bool endsWithMesh = false;
  bool beginsBefore = false;             ///< in a part of a mesh: it exists before the part
  bool endsAfter = false;                ///< in a part of a mesh: it exists after the part
  bool cavity = false;                   ///< a surface that faces inward, if surfaces are tracked
  std::vector<std::uint32_t> from = {};  ///< tracks that it came out of
  std::vector<std::uint32_t> into = {};
  /// The largest volume in a sample, or at some time of its first slab if it has none.
  double largestVolume = 0;
  std::vector<TrackSample> samples = {};  ///< in the order of time
};

struct TrackOptions {
  /// The times at which tracks are measured, in any order.
  std::vector<double> times = {};
  /// Whether they are measured at all layers, too.
  bool layers = true;
  /// Tracks every surface for itself, including those of cavities, instead of components of the
  /// solid.
  bool surfaces = false;
  /// A track that is smaller, or shorter, is left out where the others around it can go on without
  /// it (prune).
  double minVolume = 0;
  double minDuration = 0;
};

/// A cavity that appears in a solid and is filled again: its two events.
struct BriefCavity {
  std::size_t appears = 0;
  std::size_t vanishes = 0;
  double largestVolume = 0;  ///< in a sample
};

struct Tracks {
  model::TimeSpan time;
  std::vector<Track> tracks;       ///< in the order in which they begin
  std::vector<TrackEvent> events;  ///< in the order of time
  std::vector<BriefCavity> briefCavities;
  std::uint64_t prunedTracks = 0;
  std::uint64_t prunedEvents = 0;
};

/// Leaves out tracks with less than the least volume or duration, the shortest first: those that
/// appear and vanish, and those at a split or a merger that others take part in on the same side.
/// Where one track is left on either side the two are one from then on. Cavities that appear and
/// vanish are left out alike, unless surfaces were tracked.
void prune(Tracks& tracks, double minVolume, double minDuration);

struct PartOfTracks;

/// A track that is followed from slab to slab.
struct FollowedTrack {
  bool begun = false;
  bool ended = false;  ///< what happens at the last layer is known after the slab above it
  double begin = 0;
  double end = 0;
  /// Cells of the last slab: all of the track there, in its time, are connected with them by cells
  /// that share an edge then.
  std::vector<std::uint32_t> cells = {};
};

/// Tracks the components of a mesh, with a slab in memory and what is known of the components that
/// exist.
class Tracker : public model::Sink {
 public:
  /// `time` is that of the whole mesh; the times of samples are in order (sampleTimesOf).
  Tracker(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces);
  ~Tracker() override;

  /// Fails if checkConnectivity or checkSlab does.
  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;

  /// Begins after this slab, which has a duration, instead of at the begin of the mesh.
  Result<void> startAfter(const model::Slab& slab);

  /// Follows a track, by its number; before the first slab.
  void follow(std::uint32_t track);
  const FollowedTrack& followed() const;

  /// Call one of them once: after the last slab of the mesh, or after a slab with a duration that
  /// others follow.
  Tracks finish();
  PartOfTracks finishPart(bool atEnd);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The times of samples of these options, in order. Fails for a time outside the mesh.
Result<std::vector<double>> sampleTimesOf(const model::Source& source, const TrackOptions& options);

/// The tracks of a closed mesh. Slabs are worked on by all threads; the result does not depend on
/// their number. Fails for a time outside the mesh, and if reading a slab does.
Result<Tracks> tracksOf(const model::Source& source, const TrackOptions& options = {},
                        const model::Progress& progress = {});

}  // namespace t4d::measure
