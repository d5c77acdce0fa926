#include "tools/program/moving_mesh.h"

#include "t4d/formats/motion/motion_reader.h"
#include "tools/program/console.h"
#include "tools/program/solid_input.h"

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

Result<MovingMeshInput::Loaded> MovingMeshInput::read() const {
  auto loaded = SolidInput{model, bodies, mend ? &mending : nullptr, attributes}.read();
  if (!loaded) return loaded.error();
  if (loaded->mended) printNotices(noticesOf(*loaded->mended));
  std::string form;
  auto poses = formats::readMotion(motion, &form, table.table);
  if (!poses) return poses.error();
  if (!form.empty()) printNotices({motion + ": " + form});
  if (const std::string notice = model::noticeOfHalfTurns(poses->halfTurns); !notice.empty()) {
    printNotices({motion + ": " + notice});
  }
  std::vector<std::string> files = {model, motion};
  files.insert(files.end(), loaded->otherFiles.begin(), loaded->otherFiles.end());
  return Loaded{std::move(loaded->bodies), std::move(*poses),         std::move(loaded->losses),
                std::move(files),          std::move(loaded->mended), std::move(loaded->materials)};
}

}  // namespace t4d::tools
