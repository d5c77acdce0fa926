#include "formats/triangle/off_writer.h"

#include <iterator>

#include <fmt/format.h>

#include "formats/triangle/written_mesh.h"

namespace t4d::formats {

Result<std::vector<std::string>> writeOff(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  using model::Domain;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const NamedMesh& named : meshes) {
    vertices += named.mesh.vertices.size();
    triangles += named.mesh.triangles.size();
  }
  std::string origin = originComment(options);
  if (!origin.empty()) origin += ", ";
  const bool vertexColors = hasColors(meshes, Domain::Vertex, Domain::Cell);
  const bool triangleColors = hasColors(meshes, Domain::Cell, Domain::Cell);
  std::string text = fmt::format("{}OFF\n# {}written by t4d\n{} {} 0\n", vertexColors ? "C" : "",
                                 origin, vertices, triangles);
  const auto putColor = [&](const NamedMesh& named, Domain domain, std::size_t row) {
    for (const int number : sRgbOf(named, domain, row)) {
      fmt::format_to(std::back_inserter(text), " {}", number);
    }
  };
  const auto flush = [&]() -> Result<void> {
    auto done = file.write(text.data(), text.size());
    text.clear();
    return done;
  };
  for (const NamedMesh& named : meshes) {
    for (std::size_t i = 0; i < named.mesh.vertices.size(); ++i) {
      const model::Point3 vertex = named.mesh.vertices[i] - options.center;
      fmt::format_to(std::back_inserter(text), "{} {} {}", vertex.x(), vertex.y(), vertex.z());
      if (vertexColors) putColor(named, Domain::Vertex, i);
      text += "\n";
      if (auto done = flush(); !done) return done.error();
    }
  }
  std::uint64_t first = 0;
  for (const NamedMesh& named : meshes) {
    for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
      const auto& [a, b, c] = named.mesh.triangles[i];
      fmt::format_to(std::back_inserter(text), "3 {} {} {}", first + a, first + b, first + c);
      if (triangleColors) putColor(named, Domain::Cell, i);
      text += "\n";
      if (auto done = flush(); !done) return done.error();
    }
    first += named.mesh.vertices.size();
  }
  if (auto done = flush(); !done) return done.error();
  std::vector<std::string> lost;
  if (options.attributes) lost = allAttributesLost(meshes, "OFF has no room for attributes");
  if (options.normals) lost.emplace_back("normals: they are not written to OFF");
  return lost;
}

}  // namespace t4d::formats
