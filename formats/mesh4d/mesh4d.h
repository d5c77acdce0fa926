#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/slab.h"

namespace t4d::formats {

/// One body of a 4D mesh in a format without slabs: all vertices and all tetrahedra.
struct Mesh4d {
  std::string name = {};                     ///< of the body; empty if the file does not name it
  std::vector<model::Point4> vertices = {};  ///< (x, y, z, t)
  std::vector<model::Cell> cells = {};
  std::vector<model::Attribute> attributes = {};
};

/// A 4D mesh as read from a file, neither checked nor mended (edit::mendMesh4d does both).
struct LoadedMesh4d {
  std::vector<Mesh4d> bodies;  ///< at least one, each with cells
  /// How the file uses its format, if there are several ways: "Stella", "ASCII", ...
  std::string dialect = {};
  /// What was changed while reading, a sentence each: dropped cells, unused vertices, ...
  std::vector<std::string> notices = {};
  /// What the file holds and the mesh does not, a sentence each.
  std::vector<std::string> losses = {};
  /// Files that were read besides the one named.
  std::vector<std::filesystem::path> otherFiles = {};
};

}  // namespace t4d::formats
