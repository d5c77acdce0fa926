#include "edit/divide_solids.h"

#include <memory>
#include <utility>

#include "edit/derived_keys.h"
#include "edit/mend_steps.h"
#include "edit/mesh_part.h"
#include "measure/winding_number.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

/// Adds each cavity to the smallest component around it.
void addCavities(const TriangleMesh& placed, std::vector<Component>& components) {
  std::vector<TriangleMesh> alone;
  for (const Component& component : components) {
    alone.push_back(partOf(placed, component.triangles).mesh);
  }
  std::vector<bool> isCavity(components.size());
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i].volume >= 0) continue;
    const Point3& corner = placed.vertices[placed.triangles[components[i].triangles.front()][0]];
    std::size_t smallest = components.size();
    for (std::size_t k = 0; k < components.size(); ++k) {
      constexpr double kInside = 0.5;
      const bool smaller =
          smallest == components.size() || components[k].volume < components[smallest].volume;
      if (components[k].volume > 0 && smaller &&
          measure::WindingNumber::exactAt(alone[k], corner) > kInside) {
        smallest = k;
      }
    }
    if (smallest == components.size()) continue;
    isCavity[i] = true;
    auto& around = components[smallest].triangles;
    around.insert(around.end(), components[i].triangles.begin(), components[i].triangles.end());
  }
  std::size_t at = 0;
  std::erase_if(components, [&](const Component&) { return isCavity[at++]; });
}

}  // namespace

Result<std::vector<MovingSolid>> divideSolids(const TriangleMesh& mesh, Runs runs) {
  TriangleMesh placed{std::vector<Point3>(mesh.vertices.size()), mesh.triangles, {}};
  if (auto read = runs.front()->positions(0, placed.vertices); !read) return read.error();
  auto components = componentsOf(placed);
  addCavities(placed, components);
  std::vector<std::shared_ptr<const model::VertexKeys>> shared;
  for (auto& run : runs) shared.push_back(std::move(run));
  std::vector<MovingSolid> solids;
  for (const Component& component : components) {
    MeshPart part = partOf(mesh, component.triangles);
    std::vector<VertexOrigin> origins;
    for (const std::uint32_t vertex : part.vertices) origins.push_back({vertex, vertex});
    const auto local = std::make_shared<const std::vector<Point3>>(part.mesh.vertices);
    MovingSolid solid{std::move(part.mesh), {}};
    for (const auto& run : shared) {
      solid.runs.push_back(std::make_unique<KeysOfOrigins>(run, mesh.vertices.size(), origins,
                                                           std::vector<MergedPair>(), local));
    }
    solids.push_back(std::move(solid));
  }
  return solids;
}

}  // namespace t4d::edit
