#include "formats/mesh4d/gmsh_entities.h"

namespace t4d::formats {

std::string gmshName(std::string name) {
  for (char& c : name) {
    if (c == '"' || c == '\n' || c == '\r') c = '\'';
  }
  return name;
}

Result<std::vector<model::Bounds3>> gmshBounds(const FlatBodies& mesh) {
  std::vector<model::Bounds3> bounds(mesh.bodies().size());
  std::size_t body = 0;
  std::uint64_t end = mesh.bodies().empty() ? 0 : mesh.bodies()[0].vertices;
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) -> Result<void> {
    for (const model::Point4& v : vertices) {
      while (number == end) end += mesh.bodies()[++body].vertices;
      ++number;
      bounds[body].add(v.head<3>());
    }
    return {};
  });
  if (!done) return done.error();
  return bounds;
}

}  // namespace t4d::formats
