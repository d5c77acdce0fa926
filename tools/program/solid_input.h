#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/formats/triangle/triangle_mesh_writer.h"
#include "tools/program/mending.h"

namespace t4d::tools {

/// A solid in a file: one body, or several.
struct SolidInput {
  std::string path;
  std::string bodies = {};  ///< what divides it: "object", "group" or "" for one body
  const MendingOptions* mending = nullptr;  ///< null: as it is
  bool attributes = false;                  ///< the meshes have formats::LoadedMesh::attributes

  struct Loaded {
    std::vector<formats::NamedMesh> bodies;  ///< one is named after the file
    std::vector<std::string> losses;         ///< as formats::LoadedMesh
    std::vector<std::string> otherFiles;
    std::vector<std::string> materials = {};  ///< as formats::LoadedMesh
    /// Of all bodies.
    std::optional<edit::MendSurfaceReport> mended = {};
  };
  /// Reads the solid, prints its notices, and mends each body by itself.
  Result<Loaded> read() const;
};

/// Adds `--bodies`.
void addBodiesOption(CLI::App& command, std::string& bodies);

}  // namespace t4d::tools
