#include "t4d/formats/off_writer.h"

#include <iterator>

#include <fmt/format.h>

#include "t4d/formats/written_mesh.h"

namespace t4d::formats {

Result<std::vector<std::string>> writeOff(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const NamedMesh& named : meshes) {
    vertices += named.mesh.vertices.size();
    triangles += named.mesh.triangles.size();
  }
  const std::string origin = originComment(options);
  std::string text = fmt::format("OFF\n# {}\n{} {} 0\n", origin.empty() ? "written by t4d" : origin,
                                 vertices, triangles);
  const auto flush = [&]() -> Result<void> {
    auto done = file.write(text.data(), text.size());
    text.clear();
    return done;
  };
  for (const NamedMesh& named : meshes) {
    for (const model::Point3& given : named.mesh.vertices) {
      const model::Point3 vertex = given - options.center;
      fmt::format_to(std::back_inserter(text), "{} {} {}\n", vertex.x(), vertex.y(), vertex.z());
      if (auto done = flush(); !done) return pass(done.error());
    }
  }
  std::uint64_t first = 0;
  for (const NamedMesh& named : meshes) {
    for (const auto& [a, b, c] : named.mesh.triangles) {
      fmt::format_to(std::back_inserter(text), "3 {} {} {}\n", first + a, first + b, first + c);
      if (auto done = flush(); !done) return pass(done.error());
    }
    first += named.mesh.vertices.size();
  }
  if (auto done = flush(); !done) return pass(done.error());
  return options.attributes ? allAttributesLost(meshes, "OFF has no room for attributes")
                            : std::vector<std::string>{};
}

}  // namespace t4d::formats
