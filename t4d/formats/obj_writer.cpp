#include "t4d/formats/obj_writer.h"

#include <iterator>

#include <fmt/format.h>

#include "t4d/formats/written_mesh.h"

namespace t4d::formats {
namespace {

/// A name must be on one line.
std::string onOneLine(std::string name) {
  for (char& c : name) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return name;
}

}  // namespace

Result<std::vector<std::string>> writeObj(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  std::string text = "# written by t4d\n";
  if (const std::string origin = originComment(options); !origin.empty()) {
    text += "# " + origin + "\n";
  }
  const auto flush = [&]() -> Result<void> {
    auto done = file.write(text.data(), text.size());
    text.clear();
    return done;
  };
  std::uint64_t first = 1;
  for (const NamedMesh& named : meshes) {
    fmt::format_to(std::back_inserter(text), "o {}\n", onOneLine(named.name));
    for (const model::Point3& given : named.mesh.vertices) {
      const model::Point3 vertex = given - options.center;
      // "{}" is the shortest decimal that reads back as the same double.
      fmt::format_to(std::back_inserter(text), "v {} {} {}\n", vertex.x(), vertex.y(), vertex.z());
      if (auto done = flush(); !done) return pass(done.error());
    }
    for (const auto& [a, b, c] : named.mesh.triangles) {
      fmt::format_to(std::back_inserter(text), "f {} {} {}\n", first + a, first + b, first + c);
      if (auto done = flush(); !done) return pass(done.error());
    }
    first += named.mesh.vertices.size();
  }
  if (auto done = flush(); !done) return pass(done.error());
  return options.attributes ? allAttributesLost(meshes, "OBJ has no room for attributes")
                            : std::vector<std::string>{};
}

}  // namespace t4d::formats
