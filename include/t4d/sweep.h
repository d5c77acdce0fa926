#pragma once

/// The mesh method: a triangle mesh and a motion become slabs.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::mesh4d {

/// Keeps the volume of every slice at least at this fraction, R_Vmin, of the solid's: a step turns
/// by at most acos(2 R_Vmin - 1) (paper, section 4.2, eq. 2). In [0, 1).
struct MinVolumeRatio {
  double ratio = 0.998;
};

/// A fixed number of steps per segment.
struct StepsPerSegment {
  std::uint64_t steps = 1;
};

/// Keeps the Hausdorff distance between every slice and the true solid at the same time within this
/// length. model/chords.h bounds the deviation of vertices and of the points between them.
struct MaxDeviation {
  double length = 0;
};

using StepRule = std::variant<MinVolumeRatio, StepsPerSegment, MaxDeviation>;

/// The maximum number of steps of a motion, if no other is given.
inline constexpr std::uint64_t kMaxSteps = 100'000'000;

/// The division into cells of the prism that a triangle sweeps in one step.
enum class PrismSplit : std::uint8_t {
  Fourteen,  ///< the paper's symmetric division (section 4.1, fig. 6), with four new vertices
  Three,     ///< the fewest cells, no new vertices; slices between layers depend on vertex numbers
};

enum class CapMethod : std::uint8_t {
  /// Constrained Delaunay tetrahedralization (paper, section 4.1). The surface must not intersect
  /// itself. Needs a build with TetGen.
  TetGen,
  /// Joins every triangle to one apex. Works for any closed surface. Hypervolume and slices are
  /// exact, since a cap encloses nothing, but cells may overlap inside the cap.
  Cone,
};

/// The origin of a cell: the values of its attribute "kind".
enum class CellKind : std::uint8_t { Side = 0, StartCap = 1, EndCap = 2 };

/// The value of the attribute "triangle" for cells of caps, which come from no triangle.
inline constexpr std::uint32_t kNoTriangle = ~std::uint32_t{0};

/// Prisms of one step that turn over within the step.
struct Fold {
  model::TimeSpan time;
  std::uint64_t prisms = 0;    ///< how many
  std::uint32_t triangle = 0;  ///< of the first one
  model::Point3 place;         ///< the middle of the first one
};

/// A crossing of the surface with itself within one step.
struct StepCrossing {
  model::TimeSpan time;     ///< of the step
  std::uint64_t pairs = 0;  ///< pairs of triangles that meet at some time of the step
  bool complete = true;     ///< false if the search ended early
  double at = 0;            ///< a time when the first pair meets
  std::array<std::uint32_t, 2> triangles = {0, 0};  ///< of the first pair, the smaller number first
  model::Point3 place;                              ///< about where the first pair meets
};

struct SweepOptions {
  StepRule steps = MinVolumeRatio{};  ///< for motions; unused for keys, which define the steps
  CapMethod caps = CapMethod::TetGen;
  PrismSplit prism = PrismSplit::Fourteen;
  std::uint64_t maxSteps = kMaxSteps;  ///< for motions
  /// The part of the sweep to make. Parts have about the same number of steps. Only the first has
  /// the start cap, and only the last the end cap; all parts together are the sweep.
  model::Part part = {};
};

struct SweepReport {
  std::uint64_t vertices = 0;    ///< (steps + 1) V + steps (E + F), plus the points inside the caps
  std::uint64_t tetrahedra = 0;  ///< 14 F steps (or 3 F steps), plus the caps
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};  ///< at start and end
  /// A bound on the Hausdorff distance between a slice and the true solid at that time, in length
  /// units (model/chords.h). Nothing if keys were swept, since the true motion between them is
  /// unknown.
  std::optional<double> chordBound;
  /// The number of prisms that fold, and of steps with such prisms; only searched for if keys are
  /// swept.
  std::uint64_t foldedPrisms = 0;
  std::uint64_t foldedSteps = 0;
  std::vector<Fold> folds;  ///< one for each of the first kMostFolds of these steps
  /// Pairs of triangles that meet within a step, and the number of steps with such pairs. Only
  /// searched for if keys without poses are swept, in a build with CGAL.
  bool soughtCrossings = false;
  std::uint64_t crossingPairs = 0;
  std::uint64_t crossingSteps = 0;
  std::uint64_t unfinishedSteps = 0;    ///< steps in which the search ended early
  std::vector<StepCrossing> crossings;  ///< one for each of the first kMostFolds of these steps
  std::vector<std::string> notices;     ///< notes for the user, one sentence each
};

inline constexpr std::size_t kMostFolds = 100;

/// The first check of `sweep`. Fails if `mesh` is so large or so small, or `motion` takes it so far
/// away, that its shape is lost in the rounding of its coordinates.
Result<void> checkReach(const model::TriangleMesh& mesh, const model::Motion& motion);

/// Sweeps a solid through space-time and puts the boundary of the region it covers, a 4D mesh, into
/// `sink`, slab by slab: the start cap, one slab per step, the end cap (paper, section 4.1). Two
/// layers and one step are in memory at a time, however long the motion is.
///
/// `mesh` must be closed, edge- and vertex-manifold and consistently oriented; it may have several
/// components and cavities. A mesh that is inside out as a whole is flipped, with a notice. Poses
/// are in closed form, so errors do not accumulate; steps divide a segment evenly in time. Between
/// layers vertices move along straight lines. With PrismSplit::Fourteen, the slice at fraction s of
/// a step that turns by theta has exactly the volume V0 (1 - 2 s (1 - s) (1 - cos theta)), which is
/// the paper's eq. 1 at s = 1/2.
///
/// Cells have the attributes of the mesh as attributes of corners and triangles. Light slices turn
/// corner attributes into vertex attributes again.
///
/// For a part, only its slabs are made and counted. Layers where parts meet have no
/// Slab::upperPose, so that the files of parts can be joined (formats::joinT4d).
///
/// CapMethod::TetGen fills the caps in a process of its own, forked from this one, with limits on
/// memory and time: TetGen may crash or never end. The child ends before `sweep` returns.
///
/// Fails if checkClosedSurface, checkReach, stepsOf, fillSolid or the sink does, and if there are
/// fewer steps than parts.
Result<SweepReport> sweep(const model::TriangleMesh& mesh, const model::Motion& motion,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

/// Sweeps a solid that is deformed: its vertices move from key to key, and its triangles stay the
/// same. Each step from one key to the next is a slab; two keys are in memory at a time.
///
/// The mesh is closed and oriented, and exactly the given solid at every key. With
/// PrismSplit::Fourteen, the slice at fraction s of a step from the positions P to Q has exactly
/// the volume of the interpolated solid (1 - s) P + s Q. That is a cubic in s, so a step of
/// duration dt encloses exactly the hypervolume dt (V(P) + 4 V((P + Q) / 2) + V(Q)) / 6. Slices may
/// still cross themselves. Therefore each step is searched for folded prisms (Fold) and, unless
/// it leads from a pose to a pose, for triangles that meet (StepCrossing). Both are reported.
/// From a pose to a pose, folds are sought only if the solid as a whole may turn over.
///
/// `mesh` must satisfy the requirements of the sweep along a motion; `options.steps` is not used. A
/// mesh that is inside out at the first key is flipped, with a notice. At a key with a pose, the
/// cap is that of `mesh`, moved; at a key without, the deformed solid is filled. Fails for fewer
/// than two keys, times that do not increase, coordinates that are not finite, and if
/// checkClosedSurface, fillSolid, the keys or the sink do.
Result<SweepReport> sweep(const model::TriangleMesh& mesh, const model::VertexKeys& keys,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

}  // namespace t4d::mesh4d
