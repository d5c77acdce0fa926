#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "conformance/backends/backend.h"

namespace t4d::conformance {

struct ProgramOptions {
  /// A command of the shell, which gets three arguments more: CASE.obj MOTION.json OUT.t4d.
  std::string command;
  /// Of times, lengths and volumes, as a fraction of them (trueLaw).
  double tolerance = 0.01;
  double timeoutSeconds = 300;
  /// Where the files of the cases stay; empty for a temporary folder. There is one at its path.
  std::filesystem::path keep;
};

/// A program that makes a 4D mesh of each case with a triangle mesh. It gets the mesh as Wavefront
/// OBJ and the motion as JSON (docs/motion.md), writes a .t4d with one body, and exits with 0. What
/// it prints is kept beside its files as CASE.log, and its last line is in the error where it
/// fails.
///
/// How it works and in what steps is not known, so it is held to the true solid.
std::unique_ptr<Backend> programBackend(ProgramOptions options);

}  // namespace t4d::conformance
