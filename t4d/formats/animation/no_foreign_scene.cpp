#include "t4d/formats/animation/foreign_scene.h"

namespace t4d::formats {

bool readsForeignScenes() { return false; }

Result<ForeignScene> readForeignScene(const InputFile& file, bool /*keepAxes*/) {
  return fail(ErrorCode::Unsupported,
              "this build does not read FBX and COLLADA, since it has no Assimp; convert the file "
              "to glTF",
              file.path.string());
}

}  // namespace t4d::formats
