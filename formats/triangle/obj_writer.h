#pragma once

#include "formats/output_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Writes Wavefront OBJ, an `o` group a mesh: `writeTriangleMeshes` says more. The meshes have been
/// checked; the caller commits the file.
Result<std::vector<std::string>> writeObj(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options);

}  // namespace t4d::formats
