#pragma once

#include <span>
#include <string>
#include <vector>

#include "formats/output_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Writes a VTK polygonal data file (.vtp): `writeTriangleMeshes` says more. Arrays are appended,
/// raw and compressed with zlib. The meshes have been checked; the caller commits the file.
Result<std::vector<std::string>> writeVtp(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options);

}  // namespace t4d::formats
