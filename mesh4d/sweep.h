#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mesh4d/cap.h"
#include "mesh4d/folds.h"
#include "mesh4d/prism.h"
#include "mesh4d/step_crossings.h"
#include "mesh4d/steps.h"
#include "model/motion.h"
#include "model/part.h"
#include "model/slab.h"
#include "model/triangle_mesh.h"
#include "model/vertex_keys.h"

namespace t4d::mesh4d {

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
  /// units (model::Chords). Nothing if keys were swept, since the true motion between them is
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
/// Cells have the attributes of the mesh (inputAttributes in prism.h). Light slices turn corner
/// attributes into vertex attributes again.
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
/// still cross themselves. Therefore each step is searched for folded prisms (folds.h) and, unless
/// it leads from a pose to a pose, for triangles that meet (step_crossings.h). Both are reported.
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
