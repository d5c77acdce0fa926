#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

#include "formats/triangle/triangle_mesh_formats.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "t4d/slice.h"
#include "t4d/surface.h"
#include "tools/t4d/collide.h"
#include "tools/t4d/origin.h"

namespace t4d::tools {
namespace {

using measure::Collision;
using model::Point3;

/// The triangles that reach into the other solid, or within `near` of its surface or of the point.
std::vector<bool> contactOf(const model::TriangleMesh& mesh, const model::TriangleMesh& other,
                            const Point3& point, double near) {
  std::vector<bool> flags(mesh.triangles.size());
  if (other.triangles.empty() || mesh.triangles.empty()) return flags;
  const measure::TriangleTree own(mesh);
  const measure::TriangleTree tree(other);
  const measure::WindingNumber winding(other);
  const double reach = own.nearest(point).distance + near;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    bool found = own.distanceTo(i, point) <= reach;
    Point3 center = Point3::Zero();
    for (const std::uint32_t vertex : mesh.triangles[i]) center += mesh.vertices[vertex] / 3;
    found = found || tree.nearest(center, 2 * near).distance <= near || winding.at(center) > 0.75;
    flags[i] = found;
  }
  return flags;
}

formats::NamedMesh colouredMesh(const std::string& name, model::TriangleMesh mesh,
                                const std::vector<bool>& contact,
                                const std::array<float, 4>& colour) {
  constexpr std::array<float, 4> kRed = {0.6F, 0.01F, 0.02F, 1};
  formats::MeshColors colors{model::Domain::Cell, {}};
  for (const bool marked : contact) colors.colors.push_back(marked ? kRed : colour);
  formats::NamedMesh named{.name = name, .mesh = std::move(mesh)};
  named.colors = std::move(colors);
  return named;
}

/// The pair whose first contact comes first; without any contact, the one that comes nearest.
const CollidedPair& pairToShow(const std::vector<CollidedPair>& pairs) {
  const auto key = [](const CollidedPair& pair) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    if (pair.collision.contact()) return std::pair(0, pair.collision.intervals.front().begin);
    const auto& clearance = pair.collision.clearance;
    return std::pair(1, clearance ? clearance->distance : kNever);
  };
  return *std::ranges::min_element(pairs, {}, key);
}

}  // namespace

Result<std::optional<ContactView>> contactView(const CollidedPair& pair) {
  const Collision& collision = pair.collision;
  if (!collision.contact() && !collision.clearance) return std::optional<ContactView>();
  ContactView shown;
  shown.time = collision.contact() ? collision.intervals.front().begin : collision.clearance->time;
  auto a = slice::sliceAtTime(*pair.a.source, shown.time);
  if (!a) return a.error();
  auto b = slice::sliceAtTime(*pair.b.source, shown.time);
  if (!b) return b.error();
  shown.a = std::move(a->mesh);
  shown.b = std::move(b->mesh);
  shown.contactA.resize(shown.a.triangles.size());
  shown.contactB.resize(shown.b.triangles.size());
  if (collision.contact()) {
    constexpr double kNear = 1e-6;  // of the size: what is in contact up to rounding
    model::Bounds3 bounds = boundsOf(shown.a);
    bounds.add(boundsOf(shown.b));
    const double near = kNear * (bounds.max - bounds.min).norm();
    const Point3& point = collision.intervals.front().first.point;
    shown.contactA = contactOf(shown.a, shown.b, point, near);
    shown.contactB = contactOf(shown.b, shown.a, point, near);
  }
  return std::optional(std::move(shown));
}

Result<std::vector<std::string>> writeContacts(const CollideReport& report,
                                               const formats::Metadata& metadata,
                                               const std::string& path, Observer& observer) {
  const CollidedPair& pair = pairToShow(report.pairs);
  auto shown = [&] {
    const auto stage = observer.stage("drawing");
    return contactView(pair);
  }();
  if (!shown) return shown.error();
  if (!*shown) {
    observer.note(fmt::format("{} is not written: no two bodies exist at the same time", path));
    return std::vector<std::string>();
  }
  std::vector<std::string> notices;
  formats::MeshWriteOptions how;
  how.time = (*shown)->time;
  if (formats::triangleMeshFormat(path)->placed) how.placement = placementOf(metadata, notices);
  for (const std::string& notice : notices) observer.note(notice);
  const std::string nameB = pair.a.name == pair.b.name ? pair.b.name + " (2)" : pair.b.name;
  const std::vector<formats::NamedMesh> meshes = {
      colouredMesh(pair.a.name, std::move((*shown)->a), (*shown)->contactA,
                   {0.26F, 0.46F, 0.79F, 1}),
      colouredMesh(nameB, std::move((*shown)->b), (*shown)->contactB, {0.89F, 0.48F, 0.21F, 1})};
  const auto stage = observer.stage("writing " + path);
  return formats::writeTriangleMeshes(path, meshes, how);
}

}  // namespace t4d::tools
