#include "tools/verbs/moving_mesh.h"

#include <utility>

#include "t4d/motion.h"
#include "tools/verbs/mending.h"

namespace t4d::verbs {

Result<LoadedMovingMesh> readMovingMesh(const MovingMeshInput& input, Observer& observer) {
  auto solid = readSolidInput(input.solid, observer);
  if (!solid) return solid.error();
  observer.noteEach(noticesOf(solid->mended));
  std::string form;
  auto motion = formats::readMotion(input.motion, &form, input.table);
  if (!motion) return motion.error();
  if (!form.empty()) observer.note(input.motion + ": " + form);
  if (const std::string notice = model::noticeOfHalfTurns(motion->halfTurns); !notice.empty()) {
    observer.note(input.motion + ": " + notice);
  }
  std::vector<std::string> files = {input.solid.path, input.motion};
  files.insert(files.end(), solid->otherFiles.begin(), solid->otherFiles.end());
  return LoadedMovingMesh{std::move(*solid), std::move(*motion), std::move(files)};
}

}  // namespace t4d::verbs
