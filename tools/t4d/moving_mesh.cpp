#include "tools/t4d/moving_mesh.h"

#include "formats/triangle/triangle_mesh_formats.h"
#include "tools/t4d/console_observer.h"

namespace t4d::tools {

void MovingMeshInput::addTo(CLI::App& command) {
  command.add_option("MODEL", model, "Input solid: " + formats::readableTriangleMeshExtensions())
      ->required();
  command
      .add_option("-m,--motion", motion,
                  "Motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)")
      ->required();
  table.addTo(command);
  mending.addTo(command, mend);
}

Result<verbs::LoadedMovingMesh> MovingMeshInput::read() const {
  ConsoleObserver observer;
  return verbs::readMovingMesh({{model, {}, mending.given(mend)}, motion, table.table}, observer);
}

}  // namespace t4d::tools
