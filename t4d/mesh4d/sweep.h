#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "t4d/mesh4d/cap.h"
#include "t4d/mesh4d/prism.h"
#include "t4d/mesh4d/steps.h"
#include "t4d/model/motion.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::mesh4d {

/// One of several parts of a sweep, each with about the same number of steps. Only the first has
/// the start cap, and only the last the end cap: together they are the sweep.
struct SweepPart {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;
};

struct SweepOptions {
  StepRule steps = MinVolumeRatio{};
  CapMethod caps = CapMethod::TetGen;
  PrismSplit prism = PrismSplit::Fourteen;
  SweepPart part = {};
};

struct SweepReport {
  std::uint64_t vertices = 0;    ///< (steps + 1) V + steps (E + F), plus the points inside the caps
  std::uint64_t tetrahedra = 0;  ///< 14 F steps (or 3 F steps), plus the caps
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};  ///< at start and end
  std::vector<std::string> notices;                     ///< notes for the user, one sentence each
};

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
/// Of a part, only its slabs are put, and counted. Layers where parts meet come without
/// Slab::upperPose, so that the files of parts can be joined (formats::joinT4d).
///
/// Fails if checkClosedSurface, stepsOf, fillSolid or the sink does, and if there are fewer steps
/// than parts.
Result<SweepReport> sweep(const model::TriangleMesh& mesh, const model::Motion& motion,
                          const SweepOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

}  // namespace t4d::mesh4d
