#pragma once

#include <memory>
#include <vector>

#include "t4d/conformance.h"

namespace t4d::conformance {

/// Sweeps triangles (mesh4d). Ends are closed by TetGen, or by cones in a build without it.
std::unique_ptr<Backend> meshBackend();

/// Weaves voxels (voxel4d): level sets of a moving mesh, or samples of a field.
std::unique_ptr<Backend> voxelBackend();

/// Mills the stock of a case with its tool.
std::unique_ptr<Backend> millBackend();

/// All of the above, in listing order. To add a backend, write a file that defines its function,
/// declare it here, and add a line to the table in own_backends.cpp; `t4d conform backends` takes
/// the names from here.
std::vector<std::unique_ptr<Backend>> ownBackends();

}  // namespace t4d::conformance
