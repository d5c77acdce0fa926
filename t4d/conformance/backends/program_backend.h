#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "t4d/conformance/backends/backend.h"

namespace t4d::conformance {

struct ProgramOptions {
  /// As system::splitCommand takes it (t4d/system/child_process.h).
  std::string command;
  /// Of times, lengths and volumes, as a fraction of them (solidExpectation).
  double tolerance = 0.01;
  double timeoutSeconds = 300;
  /// Where the files of the cases stay; empty for a temporary folder. There is one at its path.
  std::filesystem::path keep;
};

/// A program that makes a 4D mesh of each case with a triangle mesh, called with three words more:
/// CASE.obj MOTION.json OUT.t4d. It gets the mesh as Wavefront OBJ and the motion as JSON
/// (docs/motion.md), writes a .t4d with one body, and exits with 0. What it prints is kept beside
/// its files as CASE.log, and the last line of that is in the error where it fails. Refuses a
/// command that cannot be run.
///
/// How it works and in what steps is not known, so it is held to the true solid.
Result<std::unique_ptr<Backend>> programBackend(ProgramOptions options);

}  // namespace t4d::conformance
