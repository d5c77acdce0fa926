#pragma once

#include <filesystem>

#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Measures everything that is done with a swept mesh: making it, writing and reading it, slicing
/// it. Raw arrays are what a program without slabs would keep: 32 bytes for each vertex, once, and
/// 16 for each cell. Files are made in `folder`, and removed.
///
/// Ends are cones, so that the time is that of the sweep; filling them by TetGen is a row of its
/// own, where the build has it.
Result<void> measureSweptMesh(const model::TriangleMesh& solid, const model::Motion& motion,
                              double minVolumeRatio, const std::filesystem::path& folder,
                              Report& report);

}  // namespace t4d::bench
