#include "mesh4d/cap.h"

#include <algorithm>

#include "mesh4d/prism.h"
#include "model/cone.h"
#ifdef T4D_WITH_TETGEN
#include "mesh4d/normalized.h"
#include "mesh4d/tetgen_cap.h"
#endif

namespace t4d::mesh4d {
namespace {

Cap coneCap(const model::TriangleMesh& mesh) {
  const auto apexIndex = static_cast<std::uint32_t>(mesh.vertices.size());
  Cap cap;
  cap.inner.push_back(model::coneApex(boundsOf(mesh), 1));
  cap.cells.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) cap.cells.push_back({a, c, b, apexIndex});
  return cap;
}

std::shared_ptr<model::Connectivity> capConnectivity(const Cap& cap,
                                                     const model::TriangleMesh& mesh,
                                                     CellKind kind) {
  const auto meshVertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const std::vector<std::uint32_t> triangles(cap.cells.size(), kNoTriangle);
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = meshVertices + static_cast<std::uint32_t>(cap.inner.size());
  connectivity->cells = cap.cells;
  connectivity->cellAttributes = cellAttributes(
      triangles, std::vector<std::uint8_t>(cap.cells.size(), static_cast<std::uint8_t>(kind)));
  for (model::Attribute& attribute : inputAttributes(mesh, triangles)) {
    connectivity->cellAttributes.push_back(std::move(attribute));
  }
  return connectivity;
}

}  // namespace

Result<Cap> fillSolid(const model::TriangleMesh& mesh, CapMethod method) {
  if (method == CapMethod::Cone) return coneCap(mesh);
#ifdef T4D_WITH_TETGEN
  const NormalizedMesh normalized(mesh);
  auto cap = tetgenCap(normalized.mesh());
  if (!cap) return cap;
  for (model::Point3& point : cap->inner) point = normalized.toInput(point);
  return cap;
#else
  return fail(ErrorCode::Unsupported,
              "this build is without TetGen; the ends can be closed with cones only", {},
              Remedy::ConeCaps);
#endif
}

std::shared_ptr<const model::Connectivity> startCapConnectivity(const Cap& cap,
                                                                const model::TriangleMesh& mesh) {
  auto connectivity = capConnectivity(cap, mesh, CellKind::StartCap);
  const auto meshVertices = static_cast<std::uint32_t>(mesh.vertices.size());
  connectivity->upperCount = meshVertices;
  // Inner points come before the layer here, but after it in the cap.
  const auto inner = static_cast<std::uint32_t>(cap.inner.size());
  for (model::Cell& cell : connectivity->cells) {
    for (std::uint32_t& vertex : cell) {
      vertex = vertex < meshVertices ? vertex + inner : vertex - meshVertices;
    }
  }
  return connectivity;
}

std::shared_ptr<const model::Connectivity> endCapConnectivity(const Cap& cap,
                                                              const model::TriangleMesh& mesh) {
  auto connectivity = capConnectivity(cap, mesh, CellKind::EndCap);
  connectivity->lowerCount = static_cast<std::uint32_t>(mesh.vertices.size());
  for (model::Cell& cell : connectivity->cells) std::swap(cell[0], cell[1]);
  return connectivity;
}

}  // namespace t4d::mesh4d
