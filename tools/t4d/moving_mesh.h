#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/motion.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/motion_options.h"
#include "tools/t4d/solid_input.h"

namespace t4d::tools {
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

/// A solid and its motion, as options of a verb.
struct MovingMeshArguments {
  std::string model;
  std::string motion;
  bool mend = false;
  MendingOptions mending = {};
  MotionOptions table = {};

  /// MODEL, `--motion` with its options, and `--mend` with its limits.
  void addTo(CLI::App& command);
  /// Reads both, mends the mesh if asked to, and prints the notices.
  Result<LoadedMovingMesh> read() const;
};

}  // namespace t4d::tools
