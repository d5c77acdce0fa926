#pragma once

#include "t4d/error.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Times measure::tracksOf, with samples at all layers, on one thread and on two: on a solid swept
/// along a motion, where nothing happens, and on a woven splash, where thousands of drops merge and
/// part.
Result<void> measureTrackedMeshes(const model::TriangleMesh& solid, const model::Motion& motion,
                                  double minVolumeRatio, Report& report);

}  // namespace t4d::bench
