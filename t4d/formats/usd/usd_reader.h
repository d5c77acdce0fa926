#pragma once

#include "t4d/formats/triangle/triangle_mesh_reader.h"
#include "t4d/formats/usd/usd_scene.h"

namespace t4d::formats {

/// Reads all meshes of USD text that are visible at the first time that is played, or of the first
/// file of a package (`readTriangleMesh` says more), in the units and axes of the file.
Result<LoadedMesh> readUsd(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
