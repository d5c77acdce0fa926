#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "tools/t4d/mending.h"
#include "tools/t4d/motion_options.h"
#include "tools/verbs/moving_mesh.h"

namespace t4d::tools {

/// A solid and its motion, as options of a verb.
struct MovingMeshInput {
  std::string model;
  std::string motion;
  bool mend = false;
  MendingOptions mending = {};
  MotionOptions table = {};

  /// MODEL, `--motion` with its options, and `--mend` with its limits.
  void addTo(CLI::App& command);
  /// Reads both, mends the mesh if asked to, and prints the notices.
  Result<verbs::LoadedMovingMesh> read() const;
};

}  // namespace t4d::tools
