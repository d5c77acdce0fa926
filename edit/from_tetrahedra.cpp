#include "t4d/edit.h"
#include "t4d/file.h"

namespace t4d::edit {

Result<model::Mesh> fromTetrahedra(std::span<const model::Point4> points,
                                   std::span<const model::Cell> cells) {
  const auto count = static_cast<std::uint32_t>(points.size());
  if (auto checked = model::checkCells(cells, count); !checked) return checked.error();
  formats::Mesh4d mesh;
  mesh.vertices.assign(points.begin(), points.end());
  mesh.cells.assign(cells.begin(), cells.end());
  if (auto mended = mendMesh4d(mesh); !mended) return mended.error();
  auto cut = cutIntoSlabs(std::move(mesh));
  if (!cut) return cut.error();
  return std::move(cut->mesh);
}

}  // namespace t4d::edit
