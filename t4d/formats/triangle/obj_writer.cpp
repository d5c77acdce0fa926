#include "t4d/formats/triangle/obj_writer.h"

#include <iterator>

#include <fmt/format.h>

#include "t4d/formats/triangle/written_mesh.h"

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
  std::uint64_t firstNormal = 1;
  for (const NamedMesh& named : meshes) {
    fmt::format_to(std::back_inserter(text), "o {}\n", onOneLine(named.name));
    // Colours after the coordinates are no part of the format, but many programs read them.
    const bool colored = hasColors({&named, 1}, model::Domain::Vertex, model::Domain::Vertex);
    for (std::size_t i = 0; i < named.mesh.vertices.size(); ++i) {
      const model::Point3 vertex = named.mesh.vertices[i] - options.center;
      std::string color;
      for (int k = 0; colored && k < 3; ++k) {
        color += fmt::format(" {:.4g}", sRgbOf(named, model::Domain::Vertex, i)[k] / 255.0);
      }
      // "{}" is the shortest decimal that reads back as the same double.
      fmt::format_to(std::back_inserter(text), "v {} {} {}{}\n", vertex.x(), vertex.y(), vertex.z(),
                     color);
      if (auto done = flush(); !done) return done.error();
    }
    VerticesWithNormals normals;
    if (options.normals) normals = withNormals(named.mesh, *options.normals);
    for (const Eigen::Vector3f& normal : normals.normals) {
      fmt::format_to(std::back_inserter(text), "vn {} {} {}\n", normal.x(), normal.y(), normal.z());
      if (auto done = flush(); !done) return done.error();
    }
    for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
      text += "f";
      for (int corner = 0; corner < 3; ++corner) {
        fmt::format_to(std::back_inserter(text), " {}", first + named.mesh.triangles[i][corner]);
        if (!options.normals) continue;
        fmt::format_to(std::back_inserter(text), "//{}",
                       firstNormal + normals.triangles[i][corner]);
      }
      text += "\n";
      if (auto done = flush(); !done) return done.error();
    }
    firstNormal += normals.normals.size();
    first += named.mesh.vertices.size();
  }
  if (auto done = flush(); !done) return done.error();
  std::vector<std::string> lost;
  if (options.attributes) lost = allAttributesLost(meshes, "OBJ has no room for attributes");
  if (hasColors(meshes, model::Domain::Cell, model::Domain::Vertex)) {
    lost.emplace_back("colours of triangles: OBJ has colours of vertices only");
  }
  return lost;
}

}  // namespace t4d::formats
