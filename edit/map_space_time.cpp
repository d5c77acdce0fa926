#include "edit/map_space_time.h"

#include "model/exact_sum.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::edit {

Result<MappedMesh> mapSpaceTime(const model::Source& source, const Eigen::Matrix4d& map,
                                const model::Progress& progress) {
  const int sign = model::determinantSign(map);
  if (sign == 0) return invalid("the map leaves no solid: its determinant is 0");
  MappedMesh result;
  model::NullSink nothing;
  model::AttributeNames names(nothing);
  if (auto read = model::pump(source, names); !read) return read.error();
  result.droppedAttributes = names.names();
  const auto flat = model::flatten(source, progress);
  if (!flat) return flat.error();
  formats::Mesh4d mesh;
  mesh.vertices.reserve(static_cast<std::size_t>(flat->vertices.rows()));
  for (const auto& row : flat->vertices.rowwise()) {
    mesh.vertices.emplace_back(map * row.transpose());
  }
  mesh.cells.reserve(static_cast<std::size_t>(flat->cells.rows()));
  for (const auto& row : flat->cells.rowwise()) {
    mesh.cells.push_back({row[0], row[1], row[2], row[3]});
    if (sign < 0) std::swap(mesh.cells.back()[2], mesh.cells.back()[3]);
  }
  auto cut = cutIntoSlabs(std::move(mesh));
  if (!cut) return cut.error();
  result.cut = std::move(*cut);
  return result;
}

}  // namespace t4d::edit
