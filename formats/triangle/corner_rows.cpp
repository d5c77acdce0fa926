#include "formats/triangle/corner_rows.h"

#include <cstring>

#include "model/corner_attributes.h"

namespace t4d::formats {
namespace {

constexpr std::uint64_t kNoCorner = ~std::uint64_t{0};

}  // namespace

model::Attribute cornerAttribute(const model::Attribute& rows, std::span<const std::uint32_t> rowOf,
                                 const FileCorners& corners, const model::TriangleMesh& mesh) {
  const std::size_t bytes = rows.rowBytes();
  const auto rowAt = [&](std::uint64_t corner) { return rows.row(rowOf[corner]); };
  std::vector<std::uint64_t> first(mesh.vertices.size(), kNoCorner);
  bool isOfVertices = true;
  for (std::size_t i = 0; i < mesh.triangles.size() && isOfVertices; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint64_t& known = first[mesh.triangles[i][k]];
      const std::uint64_t corner = corners.ofTriangles[i][k];
      if (known == kNoCorner) known = corner;
      if (std::memcmp(rowAt(known), rowAt(corner), bytes) != 0) isOfVertices = false;
    }
  }
  model::Attribute made{rows.name, model::Domain::Vertex, rows.type, rows.components, {}};
  const auto put = [&](std::uint64_t corner) {
    made.values.insert(made.values.end(), rowAt(corner), rowAt(corner) + bytes);
  };
  if (isOfVertices) {
    made.values.reserve(first.size() * bytes);
    for (const std::uint64_t corner : first) put(corner);
    return made;
  }
  made.name += model::kCornersOf;
  made.domain = model::Domain::Cell;
  made.components *= 3;
  made.values.reserve(mesh.triangles.size() * made.rowBytes());
  for (const auto& triangle : corners.ofTriangles) {
    for (const std::uint64_t corner : triangle) put(corner);
  }
  return made;
}

}  // namespace t4d::formats
