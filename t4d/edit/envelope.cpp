#include "t4d/edit/envelope.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "t4d/edit/mend_steps.h"
#include "t4d/edit/surface_crossings.h"
#include "t4d/measure/lattice_surface.h"
#include "t4d/measure/surface_genus.h"
#include "t4d/measure/visit_lattice.h"
#include "t4d/model/union_find.h"

namespace t4d::edit {
namespace {

using measure::LatticeSurface;
using measure::Silhouette;
using measure::SpaceLattice;
using measure::VisitLattice;
using model::Point3;
using model::TriangleMesh;

double roundedUp(double value, int digits) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - digits + 1);
  // The decimal number, not a multiple of a rounded unit.
  return std::stod(fmt::format("{:.{}e}", std::ceil(value / unit) * unit, digits - 1));
}

/// Counts parts and cavities by the volumes that connected surfaces enclose.
void measureParts(Envelope& envelope) {
  const TriangleMesh& mesh = envelope.mesh;
  envelope.volume = model::signedVolume(mesh);
  const std::vector<double> genera = measure::generaOf(mesh);
  envelope.genus = std::accumulate(genera.begin(), genera.end(), 0.0);
  model::UnionFind surfaces(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    surfaces.unite(a, b);
    surfaces.unite(b, c);
  }
  std::map<std::uint32_t, double> volumes;
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t surface = surfaces.root(a);
    // About a vertex of the surface, so that small ones far away have the right sign.
    const Point3& origin = mesh.vertices[surface];
    volumes[surface] +=
        (mesh.vertices[a] - origin).cross(mesh.vertices[b] - origin).dot(mesh.vertices[c] - origin);
  }
  for (const auto& [surface, volume] : volumes) {
    ++(volume > 0 ? envelope.components : envelope.cavities);
  }
}

TriangleMesh roundedTo(const EnvelopeOptions& options, TriangleMesh mesh) {
  if (!options.singlePrecisionAbout) return mesh;
  const Point3& center = *options.singlePrecisionAbout;
  for (Point3& vertex : mesh.vertices) {
    vertex = center + (vertex - center).cast<float>().cast<double>();
  }
  return mesh;
}

Result<Envelope> onLattice(const Silhouette& silhouette, const EnvelopeOptions& options,
                           const model::Progress& progress) {
  Envelope envelope;
  envelope.voxelSize = options.voxelSize > 0 ? options.voxelSize : defaultVoxelSize(silhouette);
  envelope.errorBound = std::numbers::sqrt3 * envelope.voxelSize;
  const TriangleMesh& surface = silhouette.surface;
  auto lattice = SpaceLattice::about(model::boundsOf(surface), envelope.voxelSize);
  if (!lattice) return pass(lattice.error());
  const double bytes = VisitLattice::estimatedBytes(surface, *lattice);
  if (bytes > options.maxBytes) {
    // Memory grows with the inverse square.
    const double fits = envelope.voxelSize * std::sqrt(bytes / options.maxBytes);
    constexpr double kGiB = 1U << 30;
    return fail(
        ErrorCode::Unsupported,
        fmt::format("a voxel size of {} would need about {:.1f} GiB of memory, more than "
                    "{:.3g} GiB; {} fits",
                    envelope.voxelSize, bytes / kGiB, options.maxBytes / kGiB, roundedUp(fits, 2)),
        {}, Remedy::VoxelSize);
  }
  const VisitLattice visits(surface, std::move(*lattice), [&](double done) {
    if (progress) progress(0.7 * done);
  });
  LatticeSurface made(visits);
  if (progress) progress(0.8);
  while (true) {
    envelope.mesh = roundedTo(options, made.mesh());
    if (!findsCrossings()) break;
    constexpr std::size_t kMost = 1'000'000;
    const auto crossings = findCrossings(envelope.mesh, kMost);
    if (!crossings) return pass(crossings.error());
    if (crossings->none()) {
      envelope.selfIntersections = 0;
      break;
    }
    std::vector<std::uint32_t> crossing = crossings->flat;
    for (const auto& [a, b] : crossings->pairs) crossing.insert(crossing.end(), {a, b});
    if (!made.makePlain(crossing)) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("rounding the vertices to {} makes triangles cross: a voxel size of {} "
                      "is too small for coordinates of this size",
                      options.singlePrecisionAbout ? "float32" : "float64", envelope.voxelSize),
          {}, Remedy::VoxelSize);
    }
  }
  return envelope;
}

Result<Envelope> exactly(const Silhouette& silhouette, const EnvelopeOptions& options) {
  if (!findsCrossings()) {
    return fail(ErrorCode::Unsupported,
                "this build has no CGAL, which exact envelopes need; give a voxel size instead");
  }
  Envelope envelope;
  TriangleMesh& mesh = envelope.mesh;
  mesh = silhouette.surface;
  const model::Bounds3 bounds = model::boundsOf(mesh);
  const double diagonal = (bounds.max - bounds.min).norm();
  Changes changes;
  weldVertices(mesh, 0);
  std::erase_if(mesh.triangles, hasTwice);
  dropUnusedVertices(mesh);
  if (auto taken = takeOuterSurface(mesh, /*nested=*/true, changes); !taken) {
    Error error = taken.error();
    error.message = "the exact envelope cannot be made: " + error.message;
    error.remedy = Remedy::None;
    return pass(std::move(error));
  }
  mesh = roundedTo(options, std::move(mesh));
  auto sound = isSound(mesh);
  if (!sound) return pass(sound.error());
  constexpr double kRounding = 0x1p-36;  // of the coordinates, after as many rounds as there may be
  envelope.errorBound =
      kRounding * std::max(bounds.max.cwiseAbs().maxCoeff(), bounds.min.cwiseAbs().maxCoeff());
  if (!*sound) {
    if (auto apart = takeApart(mesh, changes); !apart) return pass(apart.error());
    constexpr double kApart = 1e-5;
    envelope.errorBound = std::max(envelope.errorBound, kApart * diagonal);
  }
  envelope.selfIntersections = 0;
  return envelope;
}

}  // namespace

double defaultVoxelSize(const Silhouette& silhouette) {
  const model::Bounds3 bounds = model::boundsOf(silhouette.surface);
  if (bounds.empty()) return 0;
  const double extent = (bounds.max - bounds.min).maxCoeff();
  const double size = std::max(silhouette.solidExtent / 64, extent / 512);
  return size > 0 ? roundedUp(size, 2) : 0;
}

Result<Envelope> envelopeOf(const Silhouette& silhouette, const EnvelopeOptions& options,
                            const model::Progress& progress) {
  if (silhouette.surface.triangles.empty()) return Envelope{};
  auto envelope =
      options.exact ? exactly(silhouette, options) : onLattice(silhouette, options, progress);
  if (!envelope) return envelope;
  measureParts(*envelope);
  if (progress) progress(1);
  return envelope;
}

void add(Silhouette& to, const Silhouette& other) {
  const auto first = static_cast<std::uint32_t>(to.surface.vertices.size());
  to.surface.vertices.insert(to.surface.vertices.end(), other.surface.vertices.begin(),
                             other.surface.vertices.end());
  for (const auto& [a, b, c] : other.surface.triangles) {
    to.surface.triangles.push_back({a + first, b + first, c + first});
  }
  to.visitsVolume += other.visitsVolume;
  to.hypervolume += other.hypervolume;
  to.hypervolumeByFlux += other.hypervolumeByFlux;
  to.exits += other.exits;
  to.entries += other.entries;
  to.flat += other.flat;
  // The smallest body sets the scale.
  to.solidExtent =
      to.solidExtent > 0 ? std::min(to.solidExtent, other.solidExtent) : other.solidExtent;
}

}  // namespace t4d::edit
