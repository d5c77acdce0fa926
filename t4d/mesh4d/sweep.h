#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/mesh4d/cap.h"
#include "t4d/mesh4d/folds.h"
#include "t4d/mesh4d/prism.h"
#include "t4d/mesh4d/step_crossings.h"
#include "t4d/mesh4d/steps.h"
#include "t4d/model/motion.h"
#include "t4d/model/part.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"
#include "t4d/model/vertex_keys.h"

namespace t4d::mesh4d {

struct SweepOptions {
  StepRule steps = MinVolumeRatio{};  ///< of a motion; keys are steps already
  CapMethod caps = CapMethod::TetGen;
  PrismSplit prism = PrismSplit::Fourteen;
  /// Parts have about the same number of steps. Only the first has the start cap, and only the last
  /// the end cap: together they are the sweep.
  model::Part part = {};
};

struct SweepReport {
  std::uint64_t vertices = 0;    ///< (steps + 1) V + steps (E + F), plus the points inside the caps
  std::uint64_t tetrahedra = 0;  ///< 14 F steps (or 3 F steps), plus the caps
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};  ///< at start and end
  /// No point of a slice is farther from the true solid at that time, nor the other way round, in
  /// length units (model::Chords). Nothing if keys were swept: what is true between them is not
  /// known.
  std::optional<double> chordBound;
  /// Prisms that fold, and the steps that have such; only looked for when keys are swept.
  std::uint64_t foldedPrisms = 0;
  std::uint64_t foldedSteps = 0;
  std::vector<Fold> folds;  ///< of the first kMostFolds of these steps, one each
  /// Pairs of triangles that meet within a step, and the steps that have such; only looked for when
  /// keys are swept that have no poses, in a build with CGAL.
  bool soughtCrossings = false;
  std::uint64_t crossingPairs = 0;
  std::uint64_t crossingSteps = 0;
  std::uint64_t unfinishedSteps = 0;    ///< in which the search ended early
  std::vector<StepCrossing> crossings;  ///< of the first kMostFolds of these steps, one each
  std::vector<std::string> notices;     ///< notes for the user, one sentence each
};

inline constexpr std::size_t kMostFolds = 100;

/// Fails if `mesh` is so large, or so small, or `motion` takes it so far away, that its shape is
/// lost in the rounding of its coordinates: what `sweep` begins with.
Result<void> checkReach(const model::TriangleMesh& mesh, const model::Motion& motion);

/// Sweeps a solid through space-time and puts the boundary of the region it covers, a 4D mesh, into
/// `sink`, slab by slab: the start cap, one slab per step, the end cap (paper, section 4.1). Keeps
/// two layers and one step in memory, however long the motion is.
///
/// `mesh` must be closed, edge- and vertex-manifold and consistently oriented; it may have several
/// components and cavities. A mesh that is inside out as a whole is flipped, with a notice. Poses
/// are in closed form, so errors do not accumulate; steps divide a segment evenly in time. Between
/// layers vertices move on straight lines: with PrismSplit::Fourteen, the slice at fraction s of a
/// step that turns by theta has exactly the volume V0 (1 - 2 s (1 - s) (1 - cos theta)), which is
/// the paper's eq. 1 at s = 1/2.
///
/// Cells have the attributes of the mesh (inputAttributes in prism.h), from which light slices make
/// those of vertices again.
///
/// Of a part, only its slabs are put, and counted. Layers where parts meet come without
/// Slab::upperPose, so that the files of parts can be joined (formats::joinT4d).
///
/// Fails if checkClosedSurface, checkReach, stepsOf, fillSolid or the sink does, and if there are
/// fewer steps than parts.
Result<SweepReport> sweep(const model::TriangleMesh& mesh, const model::Motion& motion,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

/// Sweeps a solid that is deformed: its vertices go from key to key, and its triangles stay. Each
/// step from one key to the next is a slab; two keys are in memory at a time.
///
/// The mesh is closed and oriented, and exactly the given solid at every key. With
/// PrismSplit::Fourteen, the slice at fraction s of a step from the positions P to Q has exactly
/// the volume of the interpolated solid (1 - s) P + s Q. That is a cubic in s, so a step of
/// duration dt encloses exactly the hypervolume dt (V(P) + 4 V((P + Q) / 2) + V(Q)) / 6. What does
/// not follow is that slices do not cross themselves: each step is searched for folded prisms
/// (folds.h), and unless it leads from a pose to a pose for triangles that meet
/// (step_crossings.h), which are reported.
///
/// The requirements of `mesh` are those above; `options.steps` is not used. A mesh that is inside
/// out at the first key is flipped, with a notice. At keys without a pose the ends are filled as
/// the solid is there; with one, as `mesh` is. Fails for fewer than two keys, times that do not
/// increase, coordinates that are not finite, and if checkClosedSurface, fillSolid, the keys or the
/// sink do.
Result<SweepReport> sweep(const model::TriangleMesh& mesh, const model::VertexKeys& keys,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

}  // namespace t4d::mesh4d
