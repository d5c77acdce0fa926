#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "t4d/conformance.h"

namespace t4d::conformance {

struct ProgramOptions {
  /// The command, which platform::splitCommand (platform/child_process.h) splits into words.
  std::string command = {};
  /// Relative tolerance for times, lengths and volumes (solidExpectation).
  double tolerance = 0.01;
  double timeoutSeconds = 300;
  /// Existing folder in which to keep the files of the cases; empty for a temporary folder.
  std::filesystem::path keep = {};
};

/// A backend that calls a program to make a 4D mesh of each case with a triangle mesh. It is called
/// with three more arguments: CASE.obj MOTION.json OUT.t4d. Its input is the mesh as Wavefront OBJ
/// and the motion as JSON (docs/motion.md); it must write a .t4d with one body and exit with 0. Its
/// output is kept as CASE.log beside its files; if it fails, the error quotes the last line. Fails
/// if the command cannot be run.
///
/// The program's method and steps are unknown, so its mesh is compared with the true solid.
Result<std::unique_ptr<Backend>> programBackend(ProgramOptions options);

}  // namespace t4d::conformance
