#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "t4d/formats/triangle_mesh_formats.h"
#include "t4d/model/motion.h"

namespace t4d::tools {

/// A solid and its motion, as files.
struct MovingMeshInput {
  std::string model;
  std::string motion;

  /// MODEL and `--motion`.
  void addTo(CLI::App& command);

  struct Loaded {
    model::TriangleMesh mesh;
    model::Motion motion;
    std::vector<std::string> losses;  ///< as formats::LoadedMesh
    std::vector<std::string> files;   ///< all that were read
  };
  /// Reads both, and prints the notices of the mesh.
  Result<Loaded> read() const;
};

}  // namespace t4d::tools
