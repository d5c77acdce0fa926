#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/triangle/mesh_bodies.h"
#include "t4d/edit.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

/// A solid in a file: one body, or several.
struct SolidInput {
  std::string path;
  std::optional<formats::BodiesBy> bodies = {};          ///< what divides it; nothing for one body
  std::optional<edit::MendSurfaceOptions> mending = {};  ///< nothing: as it is
  bool attributes = false;                               ///< keep them (formats::Keep::Attributes)
};

struct LoadedSolid {
  std::vector<formats::NamedMesh> bodies;    ///< one is named after the file
  std::vector<std::string> losses = {};      ///< of reading and mending
  std::vector<std::string> otherFiles = {};  ///< that were read besides
  std::vector<std::string> materials = {};   ///< as formats::LoadedMesh
  std::vector<MendedBody> mended = {};       ///< empty if none was to be mended
};

/// Reads the solid and mends each body by itself. The observer gets the notices of the file. If
/// several bodies cannot be mended, the error has those of the others (Error::others).
Result<LoadedSolid> readSolidInput(const SolidInput& input, Observer& observer = nobody());

}  // namespace t4d::tools
