#pragma once

#include <string>
#include <vector>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/input_file.h"

namespace t4d::formats {

/// A scene of another format as binary glTF, for readGltfAnimation.
struct ForeignScene {
  InputFile glb;  ///< in memory; its path is that of the file it was made from
  std::vector<std::string> notices;
  std::vector<std::string> losses;  ///< what the file holds and the glTF does not, a sentence each
};

/// FBX and COLLADA, which a build without Assimp refuses.
inline std::vector<system::FileFormat> foreignSceneFormats() {
  return {{"animated FBX", {".fbx"}, {"triangles", "bodies", "names of bodies", "units"}},
          {"animated COLLADA", {".dae"}, {"triangles", "bodies", "names of bodies", "units"}}};
}

/// True for the name of an FBX or COLLADA file: .fbx or .dae.
inline bool isForeignScene(const std::filesystem::path& path) {
  return isOneOf(foreignSceneFormats(), path);
}

/// False in a build without Assimp.
bool readsForeignScenes();

/// Converts an FBX or COLLADA file, as Assimp reads it: nodes with their meshes, skins, and all
/// animations of nodes. Coordinates become metres, y up, by the units and axes of the file; times
/// become seconds. Numbers are float32. What concerns the look of surfaces is left out. Between
/// keys the animation is linear, whatever the curves of the file are, with a notice. Assimp runs in
/// a process of its own, since damaged files can crash it or keep it busy.
///
/// With `keepAxes`, coordinates of a COLLADA file stay in its own axes, whatever it says is up.
///
/// Fails on what Assimp cannot read, on morph targets and vertices that are animated, and on nodes
/// of equal names that are animated; in a build without Assimp always.
Result<ForeignScene> readForeignScene(const InputFile& file, bool keepAxes = false);

}  // namespace t4d::formats
