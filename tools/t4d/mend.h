#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/triangle/mesh_bodies.h"
#include "t4d/edit.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct MendOptions {
  std::string input = {};                        ///< a triangle mesh
  std::optional<formats::BodiesBy> bodies = {};  ///< of an .obj; nothing for one body
  edit::MendSurfaceOptions limits = {};          ///< for each body
  std::string output = {};                       ///< the file to write, of any triangle format
};

struct MendReport {
  std::vector<MendedBody> mended;
  std::uint64_t vertices = 0;   ///< written, of all bodies
  std::uint64_t triangles = 0;  ///< written, of all bodies
  double seconds = 0;           ///< with reading and writing
  std::vector<std::string> losses = {};
};

/// Reads a triangle mesh, mends each body by itself, and writes the file. A mesh in memory is
/// mended by edit::mendSurface. Errors have those of other bodies (Error::others). Fails (Options)
/// if the output is a file that is read.
Result<MendReport> mend(const MendOptions& options, Observer& observer = nobody());

void describe(Members& members, const MendReport& report);

}  // namespace t4d::tools
