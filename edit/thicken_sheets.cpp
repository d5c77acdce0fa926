#include "edit/thicken_sheets.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "edit/mesh_part.h"
#include "edit/surface_crossings.h"
#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// Triangles that are connected across edges, as their numbers.
std::vector<std::vector<std::uint32_t>> partsOf(const TriangleMesh& mesh,
                                                const model::SurfaceEdges& edges) {
  model::UnionFind sets(mesh.triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    for (std::uint32_t i = edge.begin + 1; i < edge.end; ++i) {
      sets.unite(edges.sides[edge.begin] / 3, edges.sides[i] / 3);
    }
  }
  std::vector<std::vector<std::uint32_t>> parts;
  std::vector<std::uint32_t> number(mesh.triangles.size(), model::kNoIndex);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    std::uint32_t& part = number[sets.root(i)];
    if (part == model::kNoIndex) {
      part = static_cast<std::uint32_t>(parts.size());
      parts.emplace_back();
    }
    parts[part].push_back(i);
  }
  return parts;
}

/// Whether a closed surface has no more inside than rounding makes of a flat one.
bool isFlat(const TriangleMesh& mesh) {
  constexpr double kOfSize = 1e-3;
  return std::abs(signedVolume(mesh)) < kOfSize * std::pow(surfaceArea(mesh), 1.5);
}

Result<bool> isSheet(TriangleMesh part) {
  const model::SurfaceEdges edges = model::edgesOf(part.triangles);
  std::vector<std::uint32_t> rim;
  for (std::uint32_t e = 0; e < edges.edges.size(); ++e) {
    if ((edges.edges[e].end - edges.edges[e].begin) % 2 != 0) rim.push_back(e);
  }
  if (rim.empty() || surfaceArea(part) > kOfRim * areaWithin(part, edges, rim)) return false;
  Changes ignored;
  if (!fillHoles(part, {}, {}, ignored) || isFlat(part)) return true;
  const auto crossings = findCrossings(part, 1);
  if (!crossings) return crossings.error();
  return !crossings->none();
}

/// The sheets, each as its triangles.
Result<std::vector<std::vector<std::uint32_t>>> sheetsOf(const TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> sheets;
  if (!findsCrossings()) return sheets;
  for (auto& part : partsOf(mesh, model::edgesOf(mesh.triangles))) {
    const auto sheet = isSheet(partOf(mesh, part).mesh);
    if (!sheet) return sheet.error();
    if (*sheet) sheets.push_back(std::move(part));
  }
  return sheets;
}

/// Adds the other sides and the rims.
void addOtherSides(ThickSheets& thick) {
  TriangleMesh& mesh = thick.mesh;
  std::vector<std::uint32_t> below(mesh.vertices.size(), model::kNoIndex);
  for (const Triangle& triangle : thick.triangles) {
    for (const std::uint32_t corner : triangle) {
      if (below[corner] != model::kNoIndex) continue;
      below[corner] = static_cast<std::uint32_t>(below.size() + thick.sheet.size());
      thick.sheet.push_back(corner);
    }
  }
  for (const auto& [a, b, c] : thick.triangles) {
    mesh.triangles.push_back({below[a], below[c], below[b]});
  }
  const model::SurfaceEdges edges = model::edgesOf(thick.triangles);
  for (const model::EdgeSides& edge : edges.edges) {
    if (edge.end - edge.begin != 1) continue;
    const Triangle& triangle = thick.triangles[edges.sides[edge.begin] / 3];
    const std::uint32_t from = triangle[edges.sides[edge.begin] % 3];
    const std::uint32_t to = triangle[(edges.sides[edge.begin] + 1) % 3];
    mesh.triangles.push_back({to, from, below[from]});
    mesh.triangles.push_back({to, below[from], below[to]});
  }
  mesh.vertices.resize(mesh.vertices.size() + thick.sheet.size());
}

}  // namespace

Result<std::size_t> countSheets(const TriangleMesh& mesh) {
  const auto sheets = sheetsOf(mesh);
  if (!sheets) return sheets.error();
  return sheets->size();
}

Result<std::optional<ThickSheets>> thickSheetsOf(const TriangleMesh& mesh, double thickness,
                                                 const model::UnitScale& scale, Changes& changes) {
  const auto count = countSheets(mesh);
  if (!count) return count.error();
  if (*count == 0) return std::nullopt;
  SplitSurface split = splitWhereTouching(mesh);
  const auto sheets = sheetsOf(split.mesh);
  if (!sheets) return sheets.error();
  ThickSheets thick{std::move(split.mesh), std::move(split.origins)};
  for (const auto& sheet : *sheets) {
    for (const std::uint32_t i : sheet) thick.triangles.push_back(thick.mesh.triangles[i]);
  }
  addOtherSides(thick);
  placeSides(thick.mesh.vertices, thick.triangles, thick.sheet, scale.toUnit(thickness));
  note(changes, SurfaceFault::Sheet, sheets->size(),
       fmt::format("gave {} a thickness of {:.6g}", numberOf(sheets->size(), "sheet", "sheets"),
                   thickness));
  return thick;
}

void placeSides(std::span<Point3> places, std::span<const Triangle> triangles,
                std::span<const std::uint32_t> sheet, double thickness) {
  std::vector<Point3> normals(places.size() - sheet.size(), Point3::Zero());
  for (const auto& [a, b, c] : triangles) {
    const Point3 normal = (places[b] - places[a]).cross(places[c] - places[a]);
    for (const std::uint32_t corner : {a, b, c}) normals[corner] += normal;
  }
  for (std::size_t i = 0; i < sheet.size(); ++i) {
    const Point3 half = thickness / 2 * normals[sheet[i]].stableNormalized();
    places[normals.size() + i] = places[sheet[i]] - half;
    places[sheet[i]] += half;
  }
}

}  // namespace t4d::edit
