#include "tools/program/moving_mesh.h"

#include "t4d/formats/motion_reader.h"
#include "tools/program/console.h"

namespace t4d::tools {

void MovingMeshInput::addTo(CLI::App& command) {
  command.add_option("MODEL", model, "The solid: " + formats::readableTriangleMeshExtensions())
      ->required();
  command
      .add_option("-m,--motion", motion,
                  "The motion: a .json file, or poses as .csv, .tsv or .txt (docs/motion.md)")
      ->required();
  mending.addTo(command, mend);
}

Result<MovingMeshInput::Loaded> MovingMeshInput::read() const {
  auto loaded = formats::readTriangleMesh(model);
  if (!loaded) return pass(loaded.error());
  printNotices(loaded->notices);
  std::optional<edit::MendSurfaceReport> mended;
  if (mend) {
    auto done = tools::mend(loaded->mesh, mending, model);
    if (!done) return pass(done.error());
    printNotices(noticesOf(*done));
    mended = std::move(*done);
  }
  auto poses = formats::readMotion(motion);
  if (!poses) return pass(poses.error());
  std::vector<std::string> files = {model, motion};
  for (const auto& file : loaded->otherFiles) files.push_back(file.string());
  return Loaded{std::move(loaded->mesh), std::move(*poses), std::move(loaded->losses),
                std::move(files), std::move(mended)};
}

}  // namespace t4d::tools
