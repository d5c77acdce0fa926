#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/edit/mend_surface.h"
#include "t4d/formats/triangle/mesh_bodies.h"
#include "t4d/verbs/observer.h"

namespace t4d::verbs {

/// A solid in a file: one body, or several.
struct SolidInput {
  std::string path;
  std::optional<formats::BodiesBy> bodies = {};          ///< what divides it; nothing for one body
  std::optional<edit::MendSurfaceOptions> mending = {};  ///< nothing: as it is
  bool attributes = false;                               ///< keep them (formats::Keep::Attributes)
};

struct LoadedSolid {
  std::vector<formats::NamedMesh> bodies;              ///< one is named after the file
  std::vector<std::string> losses = {};                ///< as formats::LoadedMesh
  std::vector<std::string> otherFiles = {};            ///< that were read besides
  std::vector<std::string> materials = {};             ///< as formats::LoadedMesh
  std::optional<edit::MendSurfaceReport> mended = {};  ///< of all bodies
};

/// Reads the solid and mends each body by itself. The observer gets the notices of the file.
Result<LoadedSolid> readSolidInput(const SolidInput& input, Observer& observer = nobody());

}  // namespace t4d::verbs
