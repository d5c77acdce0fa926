#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "edit/carried_attributes.h"
#include "edit/mend_steps.h"
#include "edit/remesh_surface.h"
#include "edit/surface_crossings.h"
#include "edit/thicken_sheets.h"
#include "model/surface_edges.h"
#include "t4d/check.h"
#include "t4d/edit.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// Takes apart what touches itself. Cuts that nearly meet leave edges so short that nothing can
/// move by a part of them: if need be, those are collapsed first, longer ones each time.
Result<void> separate(TriangleMesh& mesh, VertexLineage& lineage, Changes& changes) {
  auto apart = takeApart(mesh, lineage, changes);
  const model::Bounds3 bounds = boundsOf(mesh);
  const double size = std::max(bounds.max.cwiseAbs().maxCoeff(), bounds.min.cwiseAbs().maxCoeff());
  for (const int exponent : {-46, -42, -38}) {
    if (apart || apart.error().remedy != Remedy::Remesh) break;
    TriangleMesh shorter = mesh;
    if (weldVertices(shorter, std::ldexp(size, exponent)) == 0) continue;
    std::erase_if(shorter.triangles, hasTwice);
    Changes cleaned;
    VertexLineage ofShorter = lineage;
    if (!takeOuterSurface(shorter, false, ofShorter, cleaned)) continue;
    ofShorter.select(dropUnusedVertices(shorter));
    apart = takeApart(shorter, ofShorter, changes);
    if (!apart) continue;
    mesh = std::move(shorter);
    lineage = std::move(ofShorter);
  }
  return apart;
}

/// Steps 4 to 7 of mendSurface, on an oriented mesh in the unit of `scale`.
Result<void> closeAndSeparate(TriangleMesh& mesh, VertexLineage& lineage,
                              const MendSurfaceOptions& options, const model::UnitScale& scale,
                              Changes& changes) {
  if (options.thicken) {
    auto thick = thickSheetsOf(mesh, *options.thicken, scale, changes);
    if (!thick) return thick.error();
    if (*thick) {
      lineage.follow((*thick)->origins);
      lineage.append((*thick)->sheet);
      mesh = std::move((*thick)->mesh);
    }
  }
  if (auto filled = fillHoles(mesh, options, scale, changes); !filled) return filled;
  const bool nested = faceOutward(mesh, changes);
  if (auto outer = takeOuterSurface(mesh, nested, lineage, changes); !outer) return outer;
  if (auto apart = separate(mesh, lineage, changes); !apart) return apart;
  lineage.select(dropUnusedVertices(mesh));
  const auto sound = isSound(mesh);
  if (!sound) return sound.error();
  if (*sound) return {};
  return fail(ErrorCode::Unsupported, "the mended surface would still have faults", {},
              Remedy::Remesh);
}

/// Remeshes the surface, as a last resort.
Result<void> remesh(TriangleMesh& mesh, double voxelSize, const model::UnitScale& scale,
                    Changes& changes, const model::Progress& progress) {
  // The sign of an open surface is that of its cone from the middle.
  if (signedVolume(mesh) < 0) {
    for (Triangle& triangle : mesh.triangles) reverse(triangle);
    note(changes, SurfaceFault::InsideOut, 1, "turned the surface outward");
  }
  for (Point3& vertex : mesh.vertices) vertex = scale.fromUnit(vertex);
  auto made = remeshSurface(mesh, voxelSize, progress);
  if (!made) return made.error();
  mesh = scale.toUnit(*made);
  note(changes, SurfaceFault::Remeshed, mesh.triangles.size(),
       fmt::format("made a new surface of {} from voxels of {}",
                   numberOf(mesh.triangles.size(), "triangle", "triangles"), voxelSize));
  return {};
}

Result<void> measureMove(const TriangleMesh& before, const TriangleMesh& after,
                         const MendSurfaceOptions& options, MendSurfaceReport& report) {
  constexpr double kTolerance = 1e-4;
  double tolerance = kTolerance;
  if (options.maxMove) {
    model::Bounds3 bounds = boundsOf(before);
    bounds.add(boundsOf(after));
    constexpr double kOfMove = 1.0 / 16;
    tolerance =
        std::min(tolerance, kOfMove * *options.maxMove / (bounds.max - bounds.min).stableNorm());
  }
  const measure::SurfaceDistance moved = measure::surfaceDistance(before, after, tolerance);
  report.hausdorff = moved.hausdorff();
  if (!options.maxMove || moved.fromB + moved.tolerance <= *options.maxMove) return {};
  return invalid(
      fmt::format("the mended surface would be up to {:.6g} away from the given one, more "
                  "than {}",
                  moved.fromB, *options.maxMove),
      {}, Remedy::MaxMove);
}

model::Bounds3 boundsOfTriangles(const TriangleMesh& mesh) {
  model::Bounds3 bounds;
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) bounds.add(mesh.vertices[corner]);
  }
  return bounds;
}

}  // namespace

Result<void> checkElements(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return invalid("the mesh has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      return invalid(fmt::format("vertex {} has a coordinate that is not finite", i));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t largest = *std::ranges::max_element(mesh.triangles[i]);
    if (largest >= mesh.vertices.size()) {
      return invalid(fmt::format("triangle {} has the vertex {}, but there are only {}", i, largest,
                                 mesh.vertices.size()));
    }
  }
  return {};
}

std::string numberOf(std::uint64_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

double areaOf(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Point3& p = mesh.vertices[a];
  return (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm() / 2;
}

void measureBefore(const TriangleMesh& welded, MendSurfaceReport& report) {
  if (isClosed(welded)) report.volumeBefore = signedVolume(welded);
  report.boundsBefore = boundsOfTriangles(welded);
}

void measureAfter(const TriangleMesh& welded, const TriangleMesh& mended,
                  const MendSurfaceOptions& options, MendSurfaceReport& report) {
  report.volumeAfter = signedVolume(mended);
  report.boundsAfter = boundsOfTriangles(mended);
  const double diagonal = (report.boundsBefore.max - report.boundsBefore.min).stableNorm();
  // Beyond what taking apart moves, and folds that turn a sliver inside out; and the diagonal of
  // the box in which vertices are merged.
  constexpr double kOfDiagonal = 1e-3;
  double tolerance = kOfDiagonal * diagonal + std::sqrt(3.0) * options.weld;
  const bool remeshed = std::ranges::any_of(report.changes, [](const SurfaceChange& change) {
    return change.kind == SurfaceFault::Remeshed;
  });
  constexpr double kVoxels = 2;  // a new surface is within 1.8 of the given one
  if (remeshed) tolerance += kVoxels * *options.remesh;
  if (report.hausdorff > tolerance) report.lost = lostSurface(welded, mended, tolerance);
}

const char* nameOf(SurfaceFault kind) {
  switch (kind) {
    case SurfaceFault::Doubled:
      return "doubled";
    case SurfaceFault::Duplicate:
      return "duplicate";
    case SurfaceFault::Stray:
      return "stray";
    case SurfaceFault::Turned:
      return "turned";
    case SurfaceFault::Sheet:
      return "sheet";
    case SurfaceFault::Hole:
      return "hole";
    case SurfaceFault::InsideOut:
      return "inside-out";
    case SurfaceFault::Crossing:
      return "crossing";
    case SurfaceFault::NonManifold:
      return "non-manifold";
    case SurfaceFault::Remeshed:
      return "remeshed";
    case SurfaceFault::Hull:
      return "hull";
  }
  return "";
}

Result<MendSurfaceReport> mendSurface(TriangleMesh& mesh, const MendSurfaceOptions& options,
                                      const model::Progress& progress) {
  if (auto checked = checkElements(mesh); !checked) return checked.error();
  MendSurfaceReport report;
  TriangleMesh work{mesh.vertices, mesh.triangles, {}};
  weld(work, options.weld, report.changes);
  const TriangleMesh welded = work;
  measureBefore(welded, report);
  if (auto dropped = dropDuplicates(work, report.changes); !dropped) return dropped.error();
  const model::UnitScale scale = model::UnitScale::of({&work});
  if (scale.changes()) work = scale.toUnit(work);
  dropStray(work, report.changes);
  VertexLineage lineage(work.vertices.size());
  lineage.select(dropUnusedVertices(work));
  auto done = orient(work, report.changes);
  TriangleMesh beforeHoles = work;
  const std::size_t changesBefore = report.changes.size();
  if (done) done = closeAndSeparate(work, lineage, options, scale, report.changes);
  if (!done) {
    if (!options.remesh || done.error().remedy != Remedy::Remesh) return done.error();
    work = std::move(beforeHoles);
    report.changes.resize(changesBefore);
    done = remesh(work, *options.remesh, scale, report.changes, progress);
    if (!done) return done.error();
    const auto sound = isSound(work);
    if (!sound) return sound.error();
    if (!*sound) return fail(ErrorCode::Failed, "the new surface has faults");
    lineage = VertexLineage(0);
  }
  report.components = componentsOf(work).size();
  for (Point3& vertex : work.vertices) vertex = scale.fromUnit(vertex);
  if (!report.changes.empty()) {
    if (auto near = measureMove(mesh, work, options, report); !near) return near.error();
  }
  measureAfter(welded, work, options, report);
  report.closed = true;
  report.manifold = true;
  if (findsCrossings()) report.selfIntersections = 0;
  work.attributes = carriedAttributes(mesh, welded.triangles, work, lineage.origins());
  mesh = std::move(work);
  return report;
}

}  // namespace t4d::edit
