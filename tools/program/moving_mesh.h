#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/model/motion.h"
#include "tools/program/mending.h"
#include "tools/program/motion_options.h"

namespace t4d::tools {

/// A solid and its motion, as files.
struct MovingMeshInput {
  std::string model;
  std::string motion;
  bool mend = false;
  MendingOptions mending = {};
  std::string bodies = {};  ///< as SolidInput
  bool attributes = false;  ///< likewise
  MotionOptions table = {};

  /// MODEL, `--motion` with its options, and `--mend` with its limits.
  void addTo(CLI::App& command);

  struct Loaded {
    std::vector<formats::NamedMesh> bodies;  ///< one without `--bodies`
    model::Motion motion;
    std::vector<std::string> losses;  ///< as formats::LoadedMesh
    std::vector<std::string> files;   ///< all that were read
    std::optional<edit::MendSurfaceReport> mended = {};
    std::vector<std::string> materials = {};  ///< as SolidInput
  };
  /// Reads both, mends the mesh if asked to, and prints the notices of the mesh.
  Result<Loaded> read() const;
};

}  // namespace t4d::tools
