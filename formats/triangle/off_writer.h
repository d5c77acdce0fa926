#pragma once

#include "formats/output_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Writes .off as text, each coordinate the shortest decimal that reads back the same; several
/// meshes become one.
Result<std::vector<std::string>> writeOff(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options);

}  // namespace t4d::formats
