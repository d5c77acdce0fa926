#pragma once

#include "t4d/error.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Times measure::collide on two copies of a solid that pass through each other, and against
/// testing 1,000 frames of them with CGAL's tree of boxes, and counts what the frames miss of a
/// bullet that goes through a thin plate.
Result<void> measureCollidedMeshes(const model::TriangleMesh& solid, const model::Motion& motion,
                                   double minVolumeRatio, Report& report);

}  // namespace t4d::bench
