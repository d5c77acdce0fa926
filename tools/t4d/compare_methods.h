#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/t4d/compare.h"
#include "tools/t4d/sweep.h"

namespace t4d::tools {

/// A solid along a motion, swept by the mesh method and by the voxel method.
struct MethodsOptions {
  std::string solid;                       ///< a triangle mesh
  std::string motion;                      ///< .json, or a table of poses
  formats::MotionTableOptions table = {};  ///< for a table
  mesh4d::StepRule steps = {};
  mesh4d::CapMethod meshCaps = mesh4d::CapMethod::TetGen;
  /// Voxel sizes in length units, at least one; compared from the largest on.
  std::vector<double> voxelSizes = {};
  VoxelMethod voxels = {};     ///< its `voxelSize` is not used
  std::string folder = {};     ///< for the .t4d files; "" for one that is removed
  std::string up = {};         ///< as T4dFileOptions::up
  std::string generator = {};  ///< as T4dFileOptions::generator
};

struct MadeMesh {
  double seconds = 0;
  std::optional<std::uint64_t> peakBytes = {};  ///< memory that it took; nothing if not measured
};

/// Makes the mesh that options describe.
using MakeMesh = std::function<Result<MadeMesh>(const SweepOptions& options)>;

/// Makes it by sweep. What that takes of memory is not measured, since it cannot be told
/// from what this process has used before: for that it needs a process of its own.
MakeMesh makeHere(Observer& observer);

struct MethodsReport {
  /// The mesh method is `a`; the comparisons are by voxel size, from the largest on.
  CompareReport compared;
  std::vector<std::string> losses = {};  ///< of the file of the solid
};

/// Makes the meshes, one by the mesh method and one for each voxel size, and compares them. The
/// volume of the true solid is that of its mesh. Fails (Options) if an output would be one of the
/// files that are read, and if `make` or compare do.
Result<MethodsReport> compareMethods(const MethodsOptions& options, const CompareOptions& comparing,
                                     const MakeMesh& make, Observer& observer = nobody());

}  // namespace t4d::tools
