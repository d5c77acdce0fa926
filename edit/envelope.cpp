#include "t4d/envelope.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "edit/surface_crossings.h"
#include "measure/lattice_surface.h"
#include "measure/missed_point.h"
#include "measure/offset_surface.h"
#include "measure/surface_genus.h"
#include "measure/visit_lattice.h"
#include "model/progress.h"
#include "model/voxel_size.h"

namespace t4d::edit {
namespace {

using measure::LatticeSurface;
using measure::Silhouette;
using measure::SpaceLattice;
using measure::VisitLattice;
using model::Point3;
using model::TriangleMesh;

/// The most voxels of a default along an axis: more would take minutes.
constexpr double kMostByDefault = 4096;

/// A size of two digits.
double roundedBy(double (*rounding)(double), double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  // The decimal number, not a multiple of a rounded unit.
  return std::stod(fmt::format("{:.1e}", rounding(value / unit) * unit));
}
double roundedUp(double value) { return roundedBy(std::ceil, value); }
double roundedDown(double value) { return roundedBy(std::floor, value); }

/// The largest voxels that find a component of the solid well; 0 if that is not known.
double sizeForParts(const Silhouette& silhouette) {
  return silhouette.partExtent > 0 ? roundedDown(silhouette.partExtent / 4) : 0;
}

double largestCoordinate(const model::Bounds3& bounds, const Point3& from) {
  return std::max((bounds.max - from).cwiseAbs().maxCoeff(),
                  (bounds.min - from).cwiseAbs().maxCoeff());
}

/// The largest distance by which vertices are moved when they are written.
double roundingOfOutput(const model::Bounds3& bounds, const EnvelopeOptions& options) {
  if (!options.singlePrecisionAbout) return 0;
  constexpr double kSingle = 0x1p-23;  // half a unit in the last place, along three axes
  return kSingle * largestCoordinate(bounds, *options.singlePrecisionAbout);
}

/// The distance that the envelope keeps: more by what coordinates are off, computed and written.
double reachOf(const TriangleMesh& surface, const EnvelopeOptions& options) {
  return *options.reach + roundingOfComputing(surface) +
         roundingOfOutput(model::boundsOf(surface), options);
}

Result<SpaceLattice> latticeFor(const TriangleMesh& surface, double size,
                                const EnvelopeOptions& options) {
  model::Bounds3 bounds = model::boundsOf(surface);
  if (options.reach) {
    const double margin = measure::offsetMargin(reachOf(surface, options), size);
    bounds.min.array() -= margin;
    bounds.max.array() += margin;
  }
  return SpaceLattice::about(bounds, size);
}

/// What a surface about the silhouette takes, in times of what the one through it does: at most,
/// measured with up to five million triangles.
constexpr double kOffsetBytes = 4.5;
constexpr double kOffsetSeconds = 4;

double bytesFor(const TriangleMesh& surface, const SpaceLattice& lattice,
                const EnvelopeOptions& options) {
  return VisitLattice::estimatedBytes(surface, lattice) * (options.reach ? kOffsetBytes : 1);
}

double secondsFor(const TriangleMesh& surface, const SpaceLattice& lattice,
                  const EnvelopeOptions& options) {
  return VisitLattice::estimatedSeconds(surface, lattice) * (options.reach ? kOffsetSeconds : 1);
}

/// The smallest voxels, but no smaller than `size`, that fit into memory, this time and to the
/// coordinates; nothing if those as large as the whole surface do not.
std::optional<double> fittingVoxelSize(const TriangleMesh& surface, double size,
                                       const EnvelopeOptions& options,
                                       double seconds = std::numeric_limits<double>::infinity()) {
  const model::Bounds3 bounds = model::boundsOf(surface);
  const double extent = (bounds.max - bounds.min).maxCoeff();
  // Smaller ones are more than there can be, however small.
  size = std::max(size, extent / SpaceLattice::kMostPoints);
  while (true) {
    const auto lattice = latticeFor(surface, size, options);
    double excess = 4;
    if (lattice) {
      excess = std::max(bytesFor(surface, *lattice, options) / options.maxBytes,
                        secondsFor(surface, *lattice, options) / seconds);
      if (excess <= 1) return size;
    }
    if (size > extent) return std::nullopt;
    // Memory and time grow with the inverse square.
    size = roundedUp(size * std::max(std::sqrt(excess), 1.02));
  }
}

std::string fittingText(const TriangleMesh& surface, double size, const EnvelopeOptions& options) {
  const auto fitting = fittingVoxelSize(surface, size, options);
  return fitting ? fmt::format("{} fits", *fitting) : "no voxel size fits";
}

TriangleMesh roundedTo(const EnvelopeOptions& options, TriangleMesh mesh) {
  if (!options.singlePrecisionAbout) return mesh;
  const Point3& center = *options.singlePrecisionAbout;
  for (Point3& vertex : mesh.vertices) {
    vertex = center + (vertex - center).cast<float>().cast<double>();
  }
  return mesh;
}

/// Why an envelope is too fine.
Error tooFine(double voxelSize, const EnvelopeOptions& options) {
  const bool single = options.singlePrecisionAbout.has_value();
  return {ErrorCode::Unsupported,
          fmt::format("rounding the vertices to {} makes triangles cross: a voxel size of {} is "
                      "too small for coordinates of this size",
                      single ? "float32" : "float64", voxelSize),
          {},
          {},
          single ? Remedy::None : Remedy::VoxelSize};
}

/// The surface about the places within the reach, as it will be written.
Result<void> makeOffset(const TriangleMesh& surface, const VisitLattice& visits,
                        const EnvelopeOptions& options, Envelope& envelope,
                        const model::Progress& progress) {
  const double reach = reachOf(surface, options);
  auto offset = measure::offsetSurface(surface, visits, reach, progress);
  if (!offset) return offset.error();
  envelope.errorBound = offset->farthest;
  envelope.mesh = roundedTo(options, std::move(offset->mesh));
  if (!findsCrossings()) return {};
  const auto crossings = findCrossings(envelope.mesh, 1);
  if (!crossings) return crossings.error();
  if (!crossings->none()) return tooFine(envelope.voxelSize, options);
  envelope.selfIntersections = 0;
  return {};
}

/// Fails, without saying what to do, if rounding makes triangles cross. Empty if no point of the
/// lattice is within.
Result<Envelope> withVoxels(double voxelSize, const Silhouette& silhouette,
                            const EnvelopeOptions& options, const model::Progress& progress) {
  Envelope envelope;
  envelope.voxelSize = voxelSize;
  const TriangleMesh& surface = silhouette.surface;
  const double rounding = roundingOfOutput(model::boundsOf(surface), options);
  envelope.errorBound = std::numbers::sqrt3 * voxelSize + rounding;
  if (voxelSize < rounding) return tooFine(voxelSize, options);
  auto lattice = latticeFor(surface, voxelSize, options);
  if (!lattice) {
    Error error = lattice.error();
    error.message += "; " + fittingText(surface, voxelSize, options);
    return error;
  }
  const double bytes = bytesFor(surface, *lattice, options);
  if (bytes > options.maxBytes) {
    return model::tooMuchMemory({voxelSize, bytes, options.maxBytes}, "the envelope needs",
                                fittingText(surface, voxelSize, options));
  }
  const VisitLattice visits(surface, std::move(*lattice),
                            model::partOf(progress, 0, options.reach ? 0.2 : 0.5),
                            /*withCrossings=*/!options.reach);
  if (auto whole = visits.checkWhole(); !whole) return whole.error();
  if (options.reach) {
    auto done = makeOffset(surface, visits, options, envelope, model::partOf(progress, 0.2, 0.8));
    if (!done) return done.error();
    return envelope;
  }
  if (const auto missed = measure::missedPoint(surface, visits)) {
    envelope.losses.push_back(
        fmt::format("parts that are thinner than a voxel of {} are missing, such as at ({:.6g}, "
                    "{:.6g}, {:.6g})",
                    voxelSize, missed->x(), missed->y(), missed->z()));
  }
  LatticeSurface made(visits);
  if (auto on = model::report(progress, 0.6); !on) return on.error();
  while (true) {
    envelope.mesh = roundedTo(options, made.mesh());
    if (!findsCrossings()) break;
    constexpr std::size_t kMost = 1'000'000;
    const auto crossings = findCrossings(envelope.mesh, kMost);
    if (!crossings) return crossings.error();
    if (crossings->none()) {
      envelope.selfIntersections = 0;
      break;
    }
    std::vector<std::uint32_t> crossing = crossings->flat;
    for (const auto& [a, b] : crossings->pairs) crossing.insert(crossing.end(), {a, b});
    if (!made.makePlain(crossing)) {
      return tooFine(voxelSize, options);
    }
  }
  return envelope;
}

/// What a voxel size takes, if that is too much for a default.
std::string costText(const TriangleMesh& surface, double size, const EnvelopeOptions& options) {
  const auto lattice = latticeFor(surface, size, options);
  if (!lattice) return "more voxels than are possible";
  return fmt::format("about {:.0f} s of one core and {} of memory",
                     secondsFor(surface, *lattice, options),
                     model::memoryText(bytesFor(surface, *lattice, options)));
}

bool fitsDefault(const TriangleMesh& surface, double size, const EnvelopeOptions& options) {
  return fittingVoxelSize(surface, size, options, options.defaultSeconds) == size;
}

/// Which voxels smaller than those that found nothing do: tried as long as that takes no longer
/// than a default.
std::string finerText(const Silhouette& silhouette, const EnvelopeOptions& options, double from) {
  for (double size = from;; size = roundedUp(size / 2)) {
    if (!fitsDefault(silhouette.surface, size, options)) {
      return fmt::format("{} may find it, but takes {}", size,
                         costText(silhouette.surface, size, options));
    }
    const auto tried = withVoxels(size, silhouette, options, {});
    if (tried && !tried->mesh.triangles.empty()) return fmt::format("{} finds it", size);
  }
}

/// Why an envelope on a lattice is not all there.
std::vector<std::string> lossesOf(const Silhouette& silhouette, const Envelope& envelope,
                                  const EnvelopeOptions& options) {
  std::vector<std::string> losses;
  const double size = envelope.voxelSize;
  const bool chosen = options.voxelSize > 0;
  if (size > (chosen ? silhouette.partExtent : silhouette.partExtent / 4) &&
      silhouette.partExtent > 0) {
    const double fine = sizeForParts(silhouette);
    losses.push_back(fmt::format(
        "parts of the solid may be missing: one is only {:.3g} wide, and a voxel is {}{}",
        silhouette.partExtent, size,
        chosen ? ""
               : fmt::format(", since {} takes {}", fine,
                             costText(silhouette.surface, fine, options))));
  }
  constexpr double kVolume = 0.95;
  if (envelope.volume < kVolume * silhouette.solidVolume) {
    losses.push_back(
        fmt::format("voxels of {} are too large: the envelope has a volume of {:.6g}, but the "
                    "solid has {:.6g} already at one time",
                    size, envelope.volume, silhouette.solidVolume));
  }
  // Each part of the solid in space-time passes through a connected place.
  const std::size_t parts = measure::surfacesOf(silhouette.surface).size();
  if (envelope.components > parts) {
    losses.push_back(fmt::format(
        "voxels of {} are too large: the envelope is in {} pieces, but no more than {} can be",
        size, envelope.components, parts));
  }
  return losses;
}

/// The first size of twice, four times ... as large voxels that float32 can hold; 0 if none does
/// that still finds the solid.
double coarserForFloat32(const Silhouette& silhouette, const EnvelopeOptions& options, double size,
                         double last) {
  const double rounding = roundingOfOutput(model::boundsOf(silhouette.surface), options);
  size = std::max(size, rounding);
  for (size = roundedUp(2 * size); size <= last; size = roundedUp(2 * size)) {
    const auto tried = withVoxels(size, silhouette, options, {});
    if (tried && !tried->mesh.triangles.empty()) return size;
  }
  return 0;
}

Result<Envelope> onLattice(const Silhouette& silhouette, const EnvelopeOptions& options,
                           const model::Progress& progress) {
  double size = options.voxelSize;
  if (size > 0) {
    if (auto good = model::checkVoxelSize(size); !good) return good.error();
  } else {
    size = defaultVoxelSize(silhouette, options);
  }
  auto envelope = withVoxels(size, silhouette, options, progress);
  const double forParts = sizeForParts(silhouette);
  if (!envelope) {
    Error error = envelope.error();
    if (options.singlePrecisionAbout && error.remedy == Remedy::None && !model::isStop(error)) {
      const double works = coarserForFloat32(silhouette, options, size, forParts);
      error.message += works > 0 ? fmt::format("; {} works", works)
                                 : std::string("; none that finds the solid is large enough");
    }
    return error;
  }
  if (envelope->mesh.triangles.empty() && silhouette.visitsVolume > 0) {
    const double first = forParts > 0 ? std::min(forParts, size / 2) : size / 2;
    return fail(ErrorCode::Failed,
                fmt::format("a voxel size of {} finds nothing of the solid; {}", size,
                            finerText(silhouette, options, roundedDown(first))),
                {}, Remedy::VoxelSize);
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
  VertexLineage unused(mesh.vertices.size());
  if (auto taken = takeOuterSurface(mesh, /*always=*/true, unused, changes); !taken) {
    Error error = taken.error();
    error.message = "the exact envelope cannot be made: " + error.message;
    error.remedy = Remedy::None;
    return error;
  }
  mesh = roundedTo(options, std::move(mesh));
  auto sound = isSound(mesh);
  if (!sound) return sound.error();
  constexpr double kRounding = 0x1p-36;  // of the coordinates, after as many rounds as there may be
  envelope.errorBound =
      kRounding * largestCoordinate(bounds, Point3::Zero()) + roundingOfOutput(bounds, options);
  if (!*sound) {
    if (auto apart = takeApart(mesh, unused, changes); !apart) return apart.error();
    constexpr double kApart = 1e-5;
    envelope.errorBound = std::max(envelope.errorBound, kApart * diagonal);
  }
  envelope.selfIntersections = 0;
  return envelope;
}

}  // namespace

double defaultVoxelSize(const Silhouette& silhouette, const EnvelopeOptions& options) {
  const model::Bounds3 bounds = model::boundsOf(silhouette.surface);
  if (bounds.empty()) return 0;
  const double extent = (bounds.max - bounds.min).maxCoeff();
  const double size = std::max(silhouette.solidExtent / 64, extent / 512);
  if (!(size > 0)) return 0;
  const double usual = roundedUp(size);
  double finest = usual;
  if (options.reach) {
    // What is thin is in reach of voxels of any size, so they may be as large as the reach makes
    // the details of the surface, and as float32 asks.
    constexpr double kOfReach = 0.125;
    constexpr double kPlain = 4;
    const double large =
        std::max(kOfReach * *options.reach, kPlain * roundingOfOutput(bounds, options));
    if (large > usual) finest = roundedUp(large);
  } else if (const double forParts = sizeForParts(silhouette); forParts > 0) {
    finest = std::min(usual, std::max(forParts, roundedUp(extent / kMostByDefault)));
  }
  return fittingVoxelSize(silhouette.surface, finest, options, options.defaultSeconds)
      .value_or(usual);
}

Result<Envelope> envelopeOf(const Silhouette& silhouette, const EnvelopeOptions& options,
                            const model::Progress& progress) {
  if (options.exact && options.reach) {
    return fail(ErrorCode::Unsupported,
                "an exact envelope cannot be made to contain what is in reach of it");
  }
  if (silhouette.surface.triangles.empty()) return Envelope{};
  auto envelope =
      options.exact ? exactly(silhouette, options) : onLattice(silhouette, options, progress);
  if (!envelope) return envelope;
  measureParts(*envelope);
  if (!options.exact && !options.reach) {
    const auto losses = lossesOf(silhouette, *envelope, options);
    envelope->losses.insert(envelope->losses.end(), losses.begin(), losses.end());
  }
  if (auto on = model::report(progress, 1); !on) return on.error();
  return envelope;
}

void measureParts(Envelope& envelope) {
  const TriangleMesh& mesh = envelope.mesh;
  envelope.volume = model::signedVolume(mesh);
  envelope.genus = 0;
  envelope.components = envelope.cavities = 0;
  for (const measure::ConnectedSurface& surface : measure::surfacesOf(mesh)) {
    envelope.genus += surface.genus;
    ++(surface.volume > 0 ? envelope.components : envelope.cavities);
  }
}

double roundingOfComputing(const TriangleMesh& surface) {
  constexpr double kDouble = 0x1p-46;
  return kDouble * largestCoordinate(model::boundsOf(surface), Point3::Zero());
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
  // The smallest body sets the scale.
  const auto smaller = [](double a, double b) { return a > 0 && b > 0 ? std::min(a, b) : a + b; };
  to.solidExtent = smaller(to.solidExtent, other.solidExtent);
  to.partExtent = smaller(to.partExtent, other.partExtent);
  to.solidVolume = std::max(to.solidVolume, other.solidVolume);
}

}  // namespace t4d::edit
