#include "tools/t4d/moving_mesh.h"

#include <utility>

#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/motion.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/mending.h"

namespace t4d::tools {
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

void MovingMeshArguments::addTo(CLI::App& command) {
  command.add_option("MODEL", model, "Input solid: " + formats::readableTriangleMeshExtensions())
      ->required();
  command
      .add_option("-m,--motion", motion,
                  "Motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)")
      ->required();
  table.addTo(command);
  mending.addTo(command, mend);
}

Result<LoadedMovingMesh> MovingMeshArguments::read() const {
  ConsoleObserver observer;
  return readMovingMesh({{model, {}, mending.given(mend)}, motion, table.table}, observer);
}

}  // namespace t4d::tools
