#include "edit/mesh_part.h"

#include <unordered_map>

#include "model/attribute_rows.h"

namespace t4d::edit {

MeshPart partOf(const model::TriangleMesh& mesh, std::span<const std::uint32_t> triangles) {
  MeshPart part;
  std::unordered_map<std::uint32_t, std::uint32_t> numbers;
  for (const std::uint32_t i : triangles) {
    model::Triangle triangle = mesh.triangles[i];
    for (std::uint32_t& corner : triangle) {
      const auto [at, isNew] = numbers.try_emplace(corner, part.vertices.size());
      if (isNew) {
        part.vertices.push_back(corner);
        part.mesh.vertices.push_back(mesh.vertices[corner]);
      }
      corner = at->second;
    }
    part.mesh.triangles.push_back(triangle);
  }
  for (const model::Attribute& attribute : mesh.attributes) {
    const bool ofVertices = attribute.domain == model::Domain::Vertex;
    part.mesh.attributes.push_back(
        model::rowsOf(attribute, ofVertices ? part.vertices : triangles));
  }
  return part;
}

}  // namespace t4d::edit
