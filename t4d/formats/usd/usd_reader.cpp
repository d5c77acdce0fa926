#include "t4d/formats/usd/usd_reader.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/formats/triangle/mesh_builder.h"
#include "t4d/formats/usd/usd_shape.h"
#include "t4d/model/amount_text.h"

namespace t4d::formats {

Result<LoadedMesh> readUsd(const InputFile& file, Keep /*keep*/) {
  auto scene = readUsdScene(file);
  if (!scene) return scene.error();
  const double time = scene->played.begin;
  MeshBuilder builder(file.path.string(), [&](auto) { return file.path.string(); });
  std::vector<std::string> notices;
  std::size_t hidden = 0;
  for (const UsdPlacedMesh& placed : scene->meshes) {
    if (scene->isHidden(placed)) {
      ++hidden;
      continue;
    }
    LoadedMesh loaded;
    const auto shape = UsdShape::read(*scene, placed, UsdShape::When::AtFirst, loaded);
    if (!shape) return shape.error();
    for (const std::string& notice : loaded.notices) {
      notices.push_back(fmt::format("mesh '{}': {}", placed.name, notice));
    }
    std::vector<model::Point3> points(loaded.mesh.vertices.size());
    (*shape)->place(time, false, points);
    const std::uint64_t first = builder.pointCount();
    const bool mirrors = placed.world(time).linear().determinant() < 0;
    for (const model::Point3& point : points) {
      if (auto added = builder.addPoint(point, 0); !added) return added.error();
    }
    for (const model::Triangle& triangle : loaded.mesh.triangles) {
      const std::array<std::uint64_t, 3> corners{first + triangle[0],
                                                 first + triangle[mirrors ? 2 : 1],
                                                 first + triangle[mirrors ? 1 : 2]};
      if (auto added = builder.addPolygon(corners, 0); !added) return added.error();
    }
  }
  auto loaded = std::move(builder).finish();
  if (!loaded) return loaded;
  loaded->notices.insert(loaded->notices.begin(), notices.begin(), notices.end());
  loaded->losses = scene->losses;
  if (scene->animated) {
    loaded->losses.emplace_back("the animation: meshes are as they are at its first time");
  }
  if (hidden > 0) {
    loaded->notices.push_back(
        fmt::format("left out {}", model::counted(hidden, "invisible mesh", "invisible meshes")));
  }
  return loaded;
}

}  // namespace t4d::formats
