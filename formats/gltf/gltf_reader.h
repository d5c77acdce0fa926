#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Reads a glTF 2.0 file, text or binary, with buffers inside or beside it: the triangles of its
/// default scene (without scenes: of all nodes; without nodes: of all meshes), placed by their
/// nodes, as often as EXT_mesh_gpu_instancing says. What has scale zero is hidden and left out.
/// Reads positions at rest, and to keep attributes COLOR_0, TEXCOORD_0 and the names of materials:
/// skins, morph targets, animations, further scenes, other attributes, the look of materials,
/// images and cameras are losses, as far as they concern what is read.
Result<LoadedMesh> readGltf(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
