#include "tools/program/solid_input.h"

#include <filesystem>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/formats/triangle/mesh_bodies.h"
#include "t4d/formats/triangle/triangle_mesh_reader.h"
#include "tools/program/console.h"

namespace t4d::tools {
namespace {

Result<SolidInput::Loaded> readBodies(const SolidInput& input) {
  SolidInput::Loaded loaded;
  if (input.bodies.empty()) {
    auto read = [&] {
      const ProgressBar bar("reading " + input.path);
      return formats::readTriangleMesh(input.path);
    }();
    if (!read) return read.error();
    printNotices(read->notices);
    if (input.attributes) {
      read->mesh.attributes = std::move(read->attributes);
      read->losses = std::move(read->lossesBesideAttributes);
      loaded.materials = std::move(read->materials);
      printNotices(read->attributeNotices);
    }
    loaded.bodies.push_back(
        {std::filesystem::path(input.path).stem().string(), std::move(read->mesh)});
    loaded.losses = std::move(read->losses);
    for (const auto& file : read->otherFiles) loaded.otherFiles.push_back(file.string());
    return loaded;
  }
  auto read = formats::readMeshBodies(
      input.path, input.bodies == "group" ? formats::BodiesBy::Group : formats::BodiesBy::Object);
  if (!read) return read.error();
  printNotices(read->notices);
  loaded.bodies = std::move(read->bodies);
  if (input.attributes) {
    loaded.materials = std::move(read->materials);
    printNotices(read->attributeNotices);
  } else {
    for (formats::NamedMesh& body : loaded.bodies) body.mesh.attributes.clear();
  }
  return loaded;
}

}  // namespace

Result<SolidInput::Loaded> SolidInput::read() const {
  auto loaded = readBodies(*this);
  if (!loaded || mending == nullptr) return loaded;
  // Mended triangles have other vertices.
  std::set<std::string> dropped;
  for (formats::NamedMesh& body : loaded->bodies) {
    for (const model::Attribute& attribute : body.mesh.attributes) dropped.insert(attribute.name);
    body.mesh.attributes.clear();
  }
  if (!dropped.empty()) {
    printNotices({fmt::format("attributes are not kept where a mesh is mended: {}",
                              fmt::join(dropped, ", "))});
  }
  loaded->materials.clear();
  for (formats::NamedMesh& body : loaded->bodies) {
    const bool one = bodies.empty();
    auto done =
        mend(body.mesh, *mending, one ? path : fmt::format("{}: body '{}'", path, body.name));
    if (!done) return done.error();
    addMended(*done, one ? "" : body.name, loaded->mended);
  }
  return loaded;
}

void addBodiesOption(CLI::App& command, std::string& bodies) {
  command
      .add_option("--bodies", bodies,
                  "For .obj files: one body per object (`o`) or group (`g`), not one per file")
      ->type_name("object|group")
      ->check(CLI::IsMember({"object", "group"}));
}

}  // namespace t4d::tools
