#include "tools/t4d/solid_input.h"

#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "t4d/surface.h"
#include "tools/t4d/mending.h"

namespace t4d::tools {
namespace {

formats::Keep keepOf(const SolidInput& input) {
  return input.attributes ? formats::Keep::Attributes : formats::Keep::Shape;
}

Result<LoadedSolid> readOneBody(const SolidInput& input, Observer& observer) {
  auto read = [&] {
    const auto stage = observer.stage("reading " + input.path);
    return formats::readTriangleMesh(input.path, keepOf(input));
  }();
  if (!read) return read.error();
  LoadedSolid loaded;
  observer.noteEach(read->notices);
  loaded.materials = std::move(read->materials);
  loaded.bodies.push_back(
      {std::filesystem::path(input.path).stem().string(), std::move(read->mesh)});
  loaded.losses = std::move(read->losses);
  for (const auto& file : read->otherFiles) loaded.otherFiles.push_back(file.string());
  return loaded;
}

Result<LoadedSolid> readDividedBodies(const SolidInput& input, Observer& observer) {
  auto read = formats::readMeshBodies(input.path, *input.bodies, keepOf(input));
  if (!read) return read.error();
  LoadedSolid loaded;
  observer.noteEach(read->notices);
  loaded.bodies = std::move(read->bodies);
  loaded.materials = std::move(read->materials);
  return loaded;
}

}  // namespace

Result<LoadedSolid> readSolidInput(const SolidInput& input, Observer& observer) {
  const bool one = !input.bodies;
  auto loaded = one ? readOneBody(input, observer) : readDividedBodies(input, observer);
  if (!loaded || !input.mending) return loaded;
  std::vector<Error> errors;
  for (formats::NamedMesh& body : loaded->bodies) {
    const Place where = placeIn(input.path, one ? "" : fmt::format("body '{}'", body.name));
    auto done = mendSolid(body.mesh, *input.mending, where, observer);
    if (done) {
      loaded->mended.push_back({one ? "" : body.name, std::move(*done)});
    } else {
      errors.push_back(std::move(done.error()));
    }
  }
  if (!errors.empty()) return allErrors(std::move(errors));
  for (std::string& loss : lossesOf(loaded->mended)) loaded->losses.push_back(std::move(loss));
  return loaded;
}

}  // namespace t4d::tools
