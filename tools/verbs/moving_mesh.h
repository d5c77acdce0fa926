#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/motion.h"
#include "tools/verbs/solid_input.h"

namespace t4d::verbs {

/// A solid and its motion, as files.
struct MovingMeshInput {
  SolidInput solid;
  std::string motion;                      ///< .json, or a table of poses
  formats::MotionTableOptions table = {};  ///< for a table
};

struct LoadedMovingMesh {
  LoadedSolid solid;
  model::Motion motion;
  std::vector<std::string> files;  ///< all that were read
};

/// Reads both, and mends the mesh if asked to. The observer gets the notices of either.
Result<LoadedMovingMesh> readMovingMesh(const MovingMeshInput& input,
                                        Observer& observer = nobody());

}  // namespace t4d::verbs
